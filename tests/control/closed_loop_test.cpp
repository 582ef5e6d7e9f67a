// The cycle, the planner and the simulated world together: plan on the true shape, then grasp it.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include "prehend/control/grasp_cycle.h"
#include "prehend/grasp/planner.h"
#include "prehend/simulation/scene.h"
#include "prehend/simulation/world.h"

namespace prehend::control {
namespace {

using geometry::RigidTransform;
using simulation::GripperMode;
using simulation::World;

class SimulatedGripper : public GripperPort {
 public:
  explicit SimulatedGripper(World& world) : world_(world) {}
  void move_to(double opening, double speed) override {
    target_ = opening;
    world_.set_gripper_command(GripperMode::kPosition, opening, 0, speed);
  }
  MotionStatus motion() override {
    const auto reading = world_.gripper();
    if (std::abs(reading.opening - target_) < 1e-3) return MotionStatus::kReached;
    return reading.blocked ? MotionStatus::kContact : MotionStatus::kMoving;
  }
  void command_velocity(double speed, double current_limit) override {
    world_.set_gripper_command(GripperMode::kVelocity, speed, current_limit);
  }
  void stop() override { world_.set_gripper_command(GripperMode::kStop, 0); }

 private:
  World& world_;
  double target_ = 0;
};

class SimulatedCarrier : public CarrierPort {
 public:
  explicit SimulatedCarrier(World& world) : world_(world) {}
  void move_to(const RigidTransform& X_WG, double speed, double contact_force) override {
    contact_force_ = contact_force;
    contact_ = false;
    world_.move_carrier(X_WG, speed);
  }
  MotionStatus motion() override {
    if (contact_) return MotionStatus::kContact;
    return world_.carrier().moving ? MotionStatus::kMoving : MotionStatus::kReached;
  }
  void stop() override { world_.stop_carrier(); }
  // What a driver would do in every cycle of its loop.
  void watch() {
    if (contact_force_ > 0 && world_.wrist_wrench().force.norm() > contact_force_) {
      world_.stop_carrier();
      contact_force_ = 0;
      contact_ = true;
    }
  }

 private:
  World& world_;
  double contact_force_ = 0;
  bool contact_ = false;
};

PadPercept pad_percept(const World& world, simulation::PadSide side) {
  const auto image = world.tactile_image(side);
  const auto& pad = world.scene().gripper.pad;
  const auto touched = std::count_if(image.counts.begin(), image.counts.end(),
                                     [](std::uint16_t count) { return count > 10; });
  return {world.time(), image.sum,
          static_cast<double>(touched) * pad.texel_pitch * pad.texel_pitch};
}

struct Outcome {
  CycleResult result;
  std::vector<Surprise> surprises;
  double raised = 0;        // m
  double moved = 0;         // m
  double final_height = 0;  // m
};

// `believed` is what the plan is made on, `object` what stands there.
Outcome grasp_in_simulation(const simulation::SceneObject& object,
                            const simulation::SceneObject& believed) {
  simulation::Scene scene;
  scene.objects.push_back(object);
  World world(scene);

  const auto start = world.body(0);
  surface::ObjectModel model;
  model.mesh_W = geometry::transformed(
      simulation::object_mesh(believed),
      geometry::make_transform(
          Eigen::Quaterniond(Eigen::AngleAxisd(believed.yaw, Eigen::Vector3d::UnitZ())),
          {believed.x, believed.y, 0}));
  grasp::Reachability reachability;
  reachability.approach_W = -Eigen::Vector3d::UnitZ();
  reachability.workspace_W = {scene.carrier.minimum, scene.carrier.maximum};
  const auto plan = grasp::plan_grasps(model, geometry::Plane{}, {}, scene.gripper, reachability);

  SimulatedGripper gripper(world);
  SimulatedCarrier carrier(world);
  GraspCycle cycle(scene.gripper, CycleOptions{}, gripper, carrier);
  cycle.start(plan.grasps, plan.problem);

  Outcome outcome;
  const double first_height = start.height;
  for (int i = 0; i < 120000 && !cycle.finished(); ++i) {
    world.step();
    carrier.watch();
    outcome.raised = std::max(outcome.raised, world.body(0).height - first_height);
    if (i % 10 != 0) continue;  // 100 Hz
    Percepts percepts;
    percepts.time = world.time();
    percepts.left = pad_percept(world, simulation::PadSide::kLeft);
    percepts.right = pad_percept(world, simulation::PadSide::kRight);
    percepts.opening = world.gripper().opening;
    percepts.gripper_blocked = world.gripper().blocked;
    percepts.wrist_force = world.wrist_wrench().force.norm();
    percepts.X_WG = world.carrier().X_WG;
    cycle.step(percepts);
  }
  for (int i = 0; i < 500; ++i) world.step();
  const auto end = world.body(0);
  outcome.result = cycle.result();
  outcome.surprises = cycle.surprises();
  outcome.moved = (end.X_WB.translation() - start.X_WB.translation()).head<2>().norm();
  outcome.final_height = end.height;
  std::printf("%s: %s (%s), %d attempts, %.1f s\n", object.shape.c_str(),
              outcome.result.success ? "success" : "failure", outcome.result.reason.c_str(),
              outcome.result.attempts, world.time());
  for (const auto& s : outcome.surprises) {
    std::printf("  surprise %d: predicted %.5g felt %.5g tolerance %.3g %s\n",
                static_cast<int>(s.kind), s.predicted, s.felt, s.tolerance, s.reaction.c_str());
  }
  for (const auto& [phase, seconds] : cycle.phase_times()) {
    std::printf("  %s %.2f s\n", phase.c_str(), seconds);
  }
  return outcome;
}

Outcome grasp_in_simulation(const simulation::SceneObject& object) {
  return grasp_in_simulation(object, object);
}

void expect_carried(const Outcome& outcome) {
  EXPECT_TRUE(outcome.result.success) << outcome.result.reason;
  EXPECT_EQ(outcome.result.attempts, 1);
  EXPECT_GE(outcome.raised, 0.1);
  EXPECT_NEAR(outcome.moved, 0.15, 0.02);
  EXPECT_LT(outcome.final_height, 0.005);
  for (const auto& surprise : outcome.surprises) {
    if (surprise.kind == SurpriseKind::kContactArea) continue;  // coarse: single texels
    EXPECT_FALSE(surprise.surprising) << static_cast<int>(surprise.kind) << ": predicted "
                                      << surprise.predicted << ", felt " << surprise.felt;
  }
}

TEST(ClosedLoop, Box) {
  simulation::SceneObject object;
  object.name = "box";
  object.size = {0.05, 0.05, 0.1};
  object.mass = 0.25;
  object.yaw = 0.4;
  object.x = 0.05;
  expect_carried(grasp_in_simulation(object));
}

TEST(ClosedLoop, Carton) {
  simulation::SceneObject object;
  object.name = "carton";
  object.size = {0.072, 0.048, 0.115};
  object.mass = 0.35;
  object.yaw = 0.5;
  expect_carried(grasp_in_simulation(object));
}

TEST(ClosedLoop, Can) {
  simulation::SceneObject object;
  object.name = "can";
  object.shape = "can";
  object.radius = 0.031;
  object.height = 0.115;
  object.mass = 0.3;
  expect_carried(grasp_in_simulation(object));
}

TEST(ClosedLoop, Ball) {
  simulation::SceneObject object;
  object.name = "ball";
  object.shape = "ball";
  object.radius = 0.03;
  object.mass = 0.1;
  const Outcome outcome = grasp_in_simulation(object);
  EXPECT_TRUE(outcome.result.success) << outcome.result.reason;
  EXPECT_GE(outcome.raised, 0.1);
}

// What completion and meshing get wrong: some millimetres of place and width, some degrees of yaw.
TEST(ClosedLoop, WrongBeliefIsFeltAndSurvived) {
  simulation::SceneObject object;
  object.name = "carton";
  object.size = {0.072, 0.048, 0.115};
  object.mass = 0.35;
  object.yaw = 0.5;
  simulation::SceneObject believed = object;
  believed.x += 0.004;
  believed.y -= 0.003;
  believed.yaw += 0.06;
  believed.size.y() += 0.008;
  const Outcome outcome = grasp_in_simulation(object, believed);
  EXPECT_TRUE(outcome.result.success) << outcome.result.reason;
  EXPECT_GE(outcome.raised, 0.1);
  ASSERT_FALSE(outcome.surprises.empty());
  EXPECT_EQ(outcome.surprises.front().kind, SurpriseKind::kOpeningAtContact);
  EXPECT_TRUE(outcome.surprises.front().surprising);
}

// Nothing stands where it is believed to be: the hand closes on air and gives up in words.
TEST(ClosedLoop, MissingObject) {
  simulation::SceneObject object;
  object.name = "box";
  object.size = {0.05, 0.05, 0.1};
  object.x = 0.3;
  simulation::SceneObject believed = object;
  believed.x = 0;
  const Outcome outcome = grasp_in_simulation(object, believed);
  EXPECT_FALSE(outcome.result.success);
  EXPECT_EQ(outcome.result.attempts, 3);
  EXPECT_NE(outcome.result.reason.find("neither pad"), std::string::npos) << outcome.result.reason;
  EXPECT_LT(outcome.raised, 0.001);
}

TEST(ClosedLoop, WideBoxIsNotTried) {
  simulation::SceneObject object;
  object.name = "wide";
  object.size = {0.1, 0.094, 0.1};
  const Outcome outcome = grasp_in_simulation(object);
  EXPECT_FALSE(outcome.result.success);
  EXPECT_EQ(outcome.result.attempts, 0);
  EXPECT_EQ(outcome.result.reason,
            "cannot be grasped: narrowest width 94 mm exceeds the gripper's 69 mm");
  EXPECT_LT(outcome.raised, 0.001);
}

}  // namespace
}  // namespace prehend::control
