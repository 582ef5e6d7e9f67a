#include "prehend/simulation/robot_scene.h"

#include "prehend/geometry/errors.h"

namespace prehend::simulation {
namespace {

constexpr const char* kTakeGripper = "take the parallel gripper (platform:=stage_pg70)";

class Check {
 public:
  Check(const Scene& scene, const robot::Platform& platform) : scene_(scene), platform_(platform) {}

  std::vector<SceneRemark> run() {
    refuse_physics();
    const bool by_parameter = scene_.given.count("robot") == 0;
    const std::string& name = platform_.name;
    for (const auto& [key, line] : scene_.given) {
      const std::string top = key.substr(0, key.find('.'));
      if (top == "carrier" || top == "start_opening" || top == "gripper") {
        remark(key,
               "it is of the parallel gripper on its carrier, in whose place " + name + " stands",
               by_parameter);
      } else if (top == "tactile" && platform_.hand.pads.empty()) {
        remark(key, "the hand of " + name + " has no pads", false);
      }
    }
    return std::move(remarks_);
  }

 private:
  std::string place(const std::string& key) const {
    const auto given = scene_.given.find(key);
    if (given == scene_.given.end()) return "The scene's ";
    return scene_.file.string() + ":" + std::to_string(given->second) + ": ";
  }

  void remark(const std::string& key, const std::string& why, bool replaced) {
    remarks_.push_back(
        {place(key) + key + " has no effect: " + why + ". Leave it out, or " + kTakeGripper,
         replaced});
  }

  [[noreturn]] void refuse(const std::string& key, const std::string& why,
                           const std::string& mend) const {
    throw geometry::InputError(place(key) + key + " " + why, mend);
  }

  void refuse_physics() const {
    const PhysicsOptions& physics = scene_.physics;
    const PhysicsOptions plain;
    const std::string leave = std::string("Leave it out, or ") + kTakeGripper;
    if (physics.engine != plain.engine) {
      refuse("physics.engine",
             "is '" + physics.engine + "', which does not simulate robots of arm and hand",
             "Leave it out, since their engine is native, or " + std::string(kTakeGripper));
    }
    const std::string one_step =
        "does not apply to a robot of arm and hand, whose fingers, objects and contacts are solved "
        "in one implicit step of first order";
    const auto check = [&](bool is_plain, const std::string& key) {
      if (!is_plain) refuse("physics." + key, one_step, leave);
    };
    check(physics.solver == plain.solver, "solver");
    check(physics.integration == plain.integration, "integration");
    if (physics.adaptive) refuse("physics.step", "is adaptive and " + one_step, "Give a number");
    check(physics.tolerance == plain.tolerance, "tolerance");
    check(physics.velocity_tolerance == plain.velocity_tolerance, "velocity_tolerance");
    check(physics.most_iterations == plain.most_iterations, "most_iterations");
    if (physics.rules.rigid_pads) {
      refuse("physics.pads", "is rigid, and a hand's pads have texels", leave);
    }
    for (const auto& [key, line] : scene_.given) {
      if (key.rfind("physics.law.", 0) != 0) continue;
      refuse(key, "does not apply to a hand, whose pads have their own law",
             "Write it into the file of the hand '" + platform_.hand.name + "', as its pads' law");
    }
    const ModelRules &rules = physics.rules, own;
    check(rules.gate_texels == own.gate_texels, "rules.gate_texels");
    check(rules.remember_triangles == own.remember_triangles, "rules.remember_triangles");
    check(rules.skip_distant_pairs == own.skip_distant_pairs, "rules.skip_distant_pairs");
    check(rules.out_of_reach == own.out_of_reach, "rules.out_of_reach");
  }

  const Scene& scene_;
  const robot::Platform& platform_;
  std::vector<SceneRemark> remarks_;
};

}  // namespace

std::vector<SceneRemark> check_for_robot(const Scene& scene, const robot::Platform& platform) {
  return Check(scene, platform).run();
}

}  // namespace prehend::simulation
