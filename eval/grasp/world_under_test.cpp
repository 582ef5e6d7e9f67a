#include "eval/grasp/world_under_test.h"

#include "prehend/control/arm_in_world.h"
#include "prehend/control/stage_in_world.h"
#include "prehend/simulation/robot_world.h"
#include "prehend/simulation/stage_arm.h"
#include "prehend/simulation/world.h"

namespace prehend::eval {
namespace {

using geometry::RigidTransform;

constexpr double kWristNoise = 0.1;  // N, of the FT 300

const std::string kThing = "object";

simulation::Scene noisy_scene(const simulation::TactileOptions& tactile) {
  simulation::Scene scene;
  scene.tactile = tactile;
  scene.wrench.emplace();
  scene.wrench->force_noise = kWristNoise;
  return scene;
}

simulation::Scene stage_scene(const robot::Platform& platform, const std::string& home,
                              const simulation::TactileOptions& tactile) {
  simulation::Scene scene = noisy_scene(tactile);
  scene.gripper = *platform.hand.gripper;
  scene.start_opening = scene.gripper.max_opening;
  scene.carrier = simulation::carrier_of(platform, home);
  return scene;
}

template <class World>
void add_bodies(const TrueObject& truth, World* world) {
  world->add_object(kThing, truth.mesh_W, truth.mass, false, truth.friction);
  for (const geometry::TriangleMesh& other_W : truth.others_W) {
    world->add_object("other " + std::to_string(world->body_count()), other_W, truth.mass, true);
  }
}

class ArmUnderTest : public WorldUnderTest {
 public:
  ArmUnderTest(const robot::Platform& platform, const std::string& home, const TrueObject& truth,
               const simulation::TactileOptions& tactile)
      : world_(platform, noisy_scene(tactile), home), robot_(world_) {
    add_bodies(truth, &world_);
  }
  control::CycleWorld& robot() override { return robot_; }
  ObjectReading object() const override {
    const simulation::RobotBodyReading body = world_.body(kThing);
    return {body.X_WB, world_.X_WH().inverse(Eigen::Isometry) * body.X_WB, body.height,
            body.touches_robot};
  }

 private:
  simulation::RobotWorld world_;
  control::ArmInWorld robot_;
};

class StageUnderTest : public WorldUnderTest {
 public:
  StageUnderTest(const robot::Platform& platform, const std::string& home, const TrueObject& truth,
                 const simulation::TactileOptions& tactile)
      : world_(stage_scene(platform, home, tactile)), robot_(world_, platform, home) {
    add_bodies(truth, &world_);
  }
  control::CycleWorld& robot() override { return robot_; }
  ObjectReading object() const override {
    const simulation::BodyReading body = world_.body(kThing);
    return {body.X_WB, world_.carrier().X_WG.inverse(Eigen::Isometry) * body.X_WB, body.height,
            body.touches_left_pad || body.touches_right_pad || body.touches_gripper};
  }

 private:
  simulation::World world_;
  control::StageInWorld robot_;
};

}  // namespace

std::unique_ptr<WorldUnderTest> world_under_test(const robot::Platform& platform,
                                                 const std::string& home, const TrueObject& truth,
                                                 const simulation::TactileOptions& tactile) {
  if (platform.hand_port == robot::HandPort::kGripper) {
    return std::make_unique<StageUnderTest>(platform, home, truth, tactile);
  }
  return std::make_unique<ArmUnderTest>(platform, home, truth, tactile);
}

}  // namespace prehend::eval
