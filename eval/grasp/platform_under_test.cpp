#include "eval/grasp/platform_under_test.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <iterator>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "eval/processor_time.h"
#include "prehend/control/cycle_in_world.h"
#include "prehend/control/planned_grasp.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/simulation/robot_world.h"
#include "prehend/surface/convex_pieces.h"

namespace prehend::eval {
namespace {

using control::Phase;
using geometry::RigidTransform;

constexpr double kRaisedAtLeast = 0.05;  // m, as eval_platform
constexpr double kStands = 0.01;         // m, over the table, of what was put down
constexpr double kSettled = 0.5;         // s, after the end of the cycle
constexpr double kWristNoise = 0.1;      // N, of the FT 300
constexpr double kPatience = 1;          // s, for a new look, which takes no time here

const std::string kThing = "object";

/// What planning and executing need of a platform.
struct Subject {
  Subject(robot::Platform platform, bool reacts_in)
      : planner(std::move(platform)), reacts(reacts_in) {
    const auto& homes = planner.platform().homes;
    const bool has_side =
        std::any_of(homes.begin(), homes.end(), [](const auto& one) { return one.name == "side"; });
    home = has_side ? "side" : "home";  // as launch files have it: out of the camera's view
    start = planner.platform().home(home).arm;
  }
  planning::PlatformPlanner planner;
  bool reacts;
  std::string home;
  robot::Positions start;
};

// Of a mesh that encloses nothing its hull.
std::vector<geometry::TriangleMesh> pieces_of(const geometry::TriangleMesh& mesh_W) {
  const bool solid =
      geometry::find_defects(mesh_W).watertight() && geometry::mass_properties(mesh_W).volume > 0;
  return solid ? surface::convex_pieces(mesh_W).pieces
               : std::vector{geometry::convex_hull(mesh_W.vertices)};
}

// The truth and the Delaunay surface are bare meshes.
Belief in_pieces(Belief belief) {
  if (!belief.object.convex_pieces_W.empty()) return belief;
  belief.object.convex_pieces_W = pieces_of(belief.object.mesh_W);
  std::vector<geometry::TriangleMesh> pieces;
  for (const auto& mesh_W : belief.obstacles.meshes_W) {
    auto more = pieces_of(mesh_W);
    std::move(more.begin(), more.end(), std::back_inserter(pieces));
  }
  belief.obstacles.meshes_W = std::move(pieces);
  return belief;
}

planning::PlatformPlan plan_for(const Subject& subject, const Belief& belief,
                                const PlannerSetting& setting) {
  planning::PlatformPlanOptions options(subject.planner.platform().hand);
  options.grasps = options_for(subject.planner.platform().hand, setting);
  options.touch.emplace().threads = 1;
  const std::vector<geometry::TriangleMesh>& others_W = belief.obstacles.meshes_W;
  return subject.planner.plan(belief.object, {}, {others_W, others_W}, {}, subject.start, options);
}

/// Executes plans in a world, and watches.
class Execution {
 public:
  Execution(const Subject& subject, const TrueObject& truth)
      : subject_(subject),
        world_(subject.planner.platform(), scene(), subject.home),
        run_(world_, cycle_options(subject)) {
    world_.add_object(kThing, truth.mesh_W, truth.mass);
    for (const geometry::TriangleMesh& other_W : truth.others_W) {
      world_.add_object("other " + std::to_string(world_.body_count()), other_W, truth.mass, true);
    }
    start_ = world_.body(kThing);
  }

  void run(const planning::PlatformPlan& plan,
           const std::function<planning::PlatformPlan(const RigidTransform&)>& plan_again) {
    run_.run(
        to_try(plan), [&] { return to_try(plan_again(moved())); }, [this] { watch(); });
    for (double time = 0; time < kSettled; time += world_.options().step) world_.step();
  }

  void record(const TrueObject& truth, GraspTrial* trial) const {
    const control::CycleResult& result = run_.cycle().result();
    const simulation::RobotBodyReading end = world_.body(kThing);
    trial->attempts = result.attempts;
    trial->plans = result.plans;
    trial->stage = stage_;
    trial->outcome = stage_.empty() ? result.reason : why_;
    trial->lifted =
        result.success() && raised_ >= kRaisedAtLeast && end.height < kStands && !end.touches_robot;
    if (result.success() && !trial->lifted && stage_.empty()) {
      trial->stage = "truth";
      trial->outcome = fmt::format(
          "success was said, but it was raised by {:.0f} mm and is {:.0f} "
          "mm over the table{}",
          1e3 * raised_, 1e3 * end.height, end.touches_robot ? ", at the robot" : "");
    }
    trial->surprises = run_.cycle().surprises();
    if (!grasp_) return;
    trial->slip = slip_;
    trial->contact_error =
        mean_distance(grasp::contact_points(*grasp_),
                      geometry::MeshQuery(geometry::transformed(truth.mesh_W, X_moved_)));
    trial->robustness = grasp_->robustness;
    trial->guessed_contact = grasp_->guessed_contact;
  }

 private:
  static simulation::Scene scene() {
    simulation::Scene scene;
    scene.wrench.emplace();
    scene.wrench->force_noise = kWristNoise;
    return scene;
  }

  static control::ArmCycleOptions cycle_options(const Subject& subject) {
    control::ArmCycleOptions options;
    options.reacts = subject.reacts;
    options.look_timeout = kPatience;
    return options;
  }

  RigidTransform moved() const { return world_.body(kThing).X_WB * start_.X_WB.inverse(); }

  // As the cycle's node: what has no motion of the arm cannot be executed.
  control::GraspsToTry to_try(const planning::PlatformPlan& plan) {
    control::GraspsToTry grasps{{}, grasp::in_words(plan)};
    if (!plan.picks.empty()) tried_.clear();
    for (const planning::PlannedPick& pick : plan.picks) {
      if (pick.segments.empty()) continue;
      grasps.grasps.push_back(control::arm_grasp(subject_.planner.platform(), pick));
      tried_.push_back(pick.grasp);
    }
    return grasps;
  }

  void watch() {
    const control::ArmCycle& cycle = run_.cycle();
    const simulation::RobotBodyReading body = world_.body(kThing);
    raised_ = std::max(raised_, body.height - start_.height);
    const int attempts = cycle.result().attempts;
    if (attempts != attempts_) {
      attempts_ = attempts;
      X_moved_ = moved();
      grasp_ = tried_.at(static_cast<std::size_t>(cycle.grasp_index()));
      p_HB_.reset();
    }
    const bool failed = !cycle.failure().empty() || cycle.phase() == Phase::kFailed;
    if (failed && attempts_ <= 1 && stage_.empty()) {
      stage_ = to_string(phase_);
      why_ = cycle.failure().empty() ? cycle.result().reason : cycle.failure();
    }
    phase_ = cycle.phase();
    if (phase_ != Phase::kLift && phase_ != Phase::kMove) return;
    const Eigen::Vector3d p_HB = (world_.X_WH().inverse(Eigen::Isometry) * body.X_WB).translation();
    if (!p_HB_) p_HB_ = p_HB;
    slip_ = (p_HB - *p_HB_).norm();
  }

  const Subject& subject_;
  simulation::RobotWorld world_;
  control::CycleInWorld run_;
  simulation::RobotBodyReading start_;
  std::vector<grasp::Grasp> tried_;                      // of the present plan
  std::optional<grasp::Grasp> grasp_;                    // of the last attempt
  RigidTransform X_moved_ = RigidTransform::Identity();  // of the object when that began
  std::optional<Eigen::Vector3d> p_HB_;                  // m, when the lift began
  Phase phase_ = Phase::kWaiting;
  int attempts_ = 0;
  double raised_ = 0, slip_ = 0;  // m
  std::string stage_, why_;       // of a first attempt that failed
};

GraspTrial try_platform(const Subject& subject, const Belief& believed, const TrueObject& truth,
                        const PlannerSetting& setting, const BelieveAgain& believe_again) {
  GraspTrial trial;
  const Belief belief = in_pieces(believed);
  const double start = processor_time();
  const planning::PlatformPlan plan = plan_for(subject, belief, setting);
  trial.plan_seconds = processor_time() - start;
  trial.candidates = plan.candidates;
  trial.grasps = static_cast<int>(plan.picks.size());
  trial.problem = grasp::in_words(plan);
  trial.best_robustness = std::max(0.0, plan.robustness);
  if (plan.picks.empty()) {
    trial.stage = plan.arm_rejections.empty() ? "plan" : "arm";
    return trial;
  }
  Execution execution(subject, truth);
  execution.run(plan, [&](const RigidTransform& X_moved) {
    try {
      return plan_for(subject, in_pieces(believe_again(X_moved)), setting);
    } catch (const std::exception& error) {
      planning::PlatformPlan none;
      none.problem = error.what();
      return none;
    }
  });
  execution.record(truth, &trial);
  return trial;
}

// Whether the first preshape's tool, pointing down over a point of the table, can be as low as for
// small things and as high as for lifted ones.
class ReachFromAbove {
 public:
  explicit ReachFromAbove(const robot::Platform& platform)
      : reaches_(planning::arm_reach(platform)),
        X_GH_((platform.hand.X_HP * platform.hand.preshapes.front().X_PG).inverse()) {}

  bool operator()(const Eigen::Vector2d& p) const {
    for (const double height : {0.05, 0.3}) {
      bool reached = false;
      for (int turn = 0; turn < 4 && !reached; ++turn) {
        RigidTransform X_WG = RigidTransform::Identity();
        X_WG.linear() = (Eigen::AngleAxisd(turn * std::numbers::pi / 4, Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()))
                            .toRotationMatrix();
        X_WG.translation() << p, height;
        reached = reaches_(X_WG * X_GH_);
      }
      if (!reached) return false;
    }
    return true;
  }

 private:
  std::function<bool(const RigidTransform&)> reaches_;
  RigidTransform X_GH_;
};

}  // namespace

robot::Platform in_reach(robot::Platform platform) {
  constexpr double kStep = 0.05, kFarthest = 1.5, kRound = 0.25;  // m
  const ReachFromAbove reaches(platform);
  if (reaches(Eigen::Vector2d::Zero())) return platform;
  const Eigen::Vector2d base = platform.X_WB.translation().head<2>();
  std::vector<Eigen::Vector2d> reached;
  for (double x = -kFarthest; x <= kFarthest; x += kStep) {
    for (double y = -kFarthest; y <= kFarthest; y += kStep) {
      if (reaches(base + Eigen::Vector2d(x, y))) reached.emplace_back(base + Eigen::Vector2d(x, y));
    }
  }
  if (reached.empty()) {
    throw geometry::InputError(
        "The arm of platform '" + platform.name + "' reaches nothing on the table from above",
        "Look at `mount`, `world` and the preshapes' tools in its file");
  }
  // The middle: with most of what is reached round it, and of those the nearest.
  const auto round_it = [&](const Eigen::Vector2d& p) {
    return std::count_if(reached.begin(), reached.end(),
                         [&](const Eigen::Vector2d& q) { return (p - q).norm() < kRound; });
  };
  const auto best = std::max_element(
      reached.begin(), reached.end(), [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
        return std::pair(round_it(a), -a.norm()) < std::pair(round_it(b), -b.norm());
      });
  platform.X_WB.translation().head<2>() -= *best;
  return platform;
}

HandUnderTest platform_under_test(const std::filesystem::path& file, bool reacts) {
  robot::Platform platform = robot::read_platform(file);
  if (platform.hand_port == robot::HandPort::kGripper) {
    throw geometry::InputError("Platform '" + platform.name +
                                   "' moves its gripper through /gripper, in another world than "
                                   "arms with hands",
                               "Evaluate its gripper (--hand), or all of it (eval_platform)");
  }
  const auto subject = std::make_shared<const Subject>(in_reach(std::move(platform)), reacts);
  return {subject->planner.platform().name,
          [subject](const Belief& believed, const TrueObject& truth, const PlannerSetting& setting,
                    const BelieveAgain& believe_again) {
            return try_platform(*subject, believed, truth, setting, believe_again);
          }};
}

}  // namespace prehend::eval
