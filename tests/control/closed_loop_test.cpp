// The cycle, the planner and the simulated world together: plan on the true shape, then grasp it.

#include <algorithm>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include "eval/grasp/grasp_execution.h"
#include "prehend/grasp/planner.h"
#include "prehend/simulation/scene.h"
#include "prehend/simulation/world.h"

namespace prehend::control {
namespace {

using Outcome = eval::GraspExecution;

// `believed` is what the plan is made on, `object` what stands there.
Outcome grasp_in_simulation(const simulation::SceneObject& object,
                            const simulation::SceneObject& believed) {
  simulation::Scene scene;
  scene.objects.push_back(object);
  simulation::World world(scene);

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

  const Outcome outcome = eval::execute_grasps(world, 0, plan);
  std::printf("%s: %s (%s), %d attempts, %.1f s\n", object.shape.c_str(),
              outcome.result.success() ? "success" : "failure", outcome.result.reason.c_str(),
              outcome.result.attempts, world.time());
  for (const auto& s : outcome.surprises) {
    std::printf("  surprise %d: predicted %.5g felt %.5g tolerance %.3g %s\n",
                static_cast<int>(s.kind), s.predicted, s.felt, s.tolerance, s.reaction.c_str());
  }
  for (const auto& [phase, seconds] : outcome.phase_times) {
    std::printf("  %s %.2f s\n", phase.c_str(), seconds);
  }
  return outcome;
}

Outcome grasp_in_simulation(const simulation::SceneObject& object) {
  return grasp_in_simulation(object, object);
}

void expect_carried(const Outcome& outcome) {
  EXPECT_TRUE(outcome.result.success()) << outcome.result.reason;
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
  EXPECT_TRUE(outcome.result.success()) << outcome.result.reason;
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
  EXPECT_TRUE(outcome.result.success()) << outcome.result.reason;
  EXPECT_GE(outcome.raised, 0.1);
  EXPECT_TRUE(
      std::any_of(outcome.surprises.begin(), outcome.surprises.end(), [](const Surprise& surprise) {
        return surprise.kind == SurpriseKind::kOpeningAtContact && surprise.surprising;
      }));
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
  EXPECT_FALSE(outcome.result.success());
  EXPECT_EQ(outcome.result.attempts, 3);
  EXPECT_NE(outcome.result.reason.find("neither pad"), std::string::npos) << outcome.result.reason;
  EXPECT_LT(outcome.raised, 0.001);
}

TEST(ClosedLoop, WideBoxIsNotTried) {
  simulation::SceneObject object;
  object.name = "wide";
  object.size = {0.1, 0.094, 0.1};
  const Outcome outcome = grasp_in_simulation(object);
  EXPECT_FALSE(outcome.result.success());
  EXPECT_EQ(outcome.result.attempts, 0);
  EXPECT_EQ(outcome.result.reason,
            "cannot be grasped: narrowest width 94 mm exceeds the gripper's 69 mm");
  EXPECT_LT(outcome.raised, 0.001);
}

}  // namespace
}  // namespace prehend::control
