// Planner, cycle and simulated world of the PG70 on its stage together, as they ship.

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "prehend/control/stage_in_world.h"
#include "prehend/simulation/scene.h"
#include "tests/control/pick_of.h"

namespace prehend::control {
namespace {

struct Outcome {
  CycleResult result;
  std::vector<Surprise> surprises;
  double raised = 0;                                    // m, at most, over where it stood
  Eigen::Vector3d moved_W = Eigen::Vector3d::Zero();    // m, from where it stood
  Eigen::Vector3d to_move_W = Eigen::Vector3d::Zero();  // m, as the first grasp was planned
  double final_height = 0;                              // m, of its lowest point, after the end
};

geometry::TriangleMesh standing(const simulation::SceneObject& object) {
  return geometry::transformed(simulation::object_mesh(object),
                               geometry::make_transform(Eigen::Quaterniond(Eigen::AngleAxisd(
                                                            object.yaw, Eigen::Vector3d::UnitZ())),
                                                        {object.x, object.y, 0}));
}

// `believed` is what the plan is made on, `object` what stands there.
Outcome grasp_in_simulation(const simulation::SceneObject& object,
                            const simulation::SceneObject& believed) {
  static const PickOf planned("stage_pg70");
  simulation::Scene scene;
  scene.objects.push_back(object);
  scene.gripper = *planned.platform().hand.gripper;
  scene.carrier = simulation::carrier_of(planned.platform(), "side");
  simulation::World world(scene);
  const simulation::BodyReading start = world.body(0);
  const planning::PlatformPlan plan = planned.plan(standing(believed));

  Outcome outcome;
  if (!plan.picks.empty()) outcome.to_move_W = plan.picks.front().move_W.value();
  StageInWorld stage(world, planned.platform(), "side");
  CycleInWorld in_world(stage, reacting());
  outcome.result = in_world.run(planned.to_try(plan), nullptr, [&] {
    outcome.raised = std::max(outcome.raised, world.body(0).height - start.height);
  });
  stage.advance(500);
  outcome.surprises = in_world.cycle().surprises();
  outcome.moved_W = world.body(0).X_WB.translation() - start.X_WB.translation();
  outcome.final_height = world.body(0).height;
  return outcome;
}

Outcome grasp_in_simulation(const simulation::SceneObject& object) {
  return grasp_in_simulation(object, object);
}

void expect_carried(const Outcome& outcome) {
  EXPECT_TRUE(outcome.result.success()) << outcome.result.reason;
  EXPECT_EQ(outcome.result.attempts, 1);
  EXPECT_GE(outcome.raised, 0.1);
  EXPECT_GT(outcome.to_move_W.norm(), 0.05);
  EXPECT_LT((outcome.moved_W - outcome.to_move_W).head<2>().norm(), 0.02);
  EXPECT_LT(outcome.final_height, 0.005);
  for (const auto& surprise : outcome.surprises) {
    if (surprise.kind == SurpriseKind::kContactArea) continue;  // coarse: single texels
    EXPECT_FALSE(surprise.surprising) << to_string(surprise.kind) << ": predicted "
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
