// Platforms pick what their planner plans on, by the shipped cycle, in one process.

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/control/arm_in_world.h"
#include "prehend/simulation/shapes.h"
#include "tests/control/pick_of.h"

namespace prehend::control {
namespace {

constexpr double kMass = 0.3;  // kg

class PlatformCycle : public testing::TestWithParam<const char*> {
 protected:
  simulation::RobotWorld world_of(const geometry::TriangleMesh& mesh_W) const {
    simulation::Scene scene;
    scene.wrench.emplace();
    scene.wrench->force_noise = 0.1;
    simulation::RobotWorld world(planned.platform(), scene, "side");
    world.add_object("thing", mesh_W, kMass);
    return world;
  }

  const PickOf planned{GetParam()};
};

struct Picked {
  CycleResult result;
  double highest = 0;  // m
  simulation::RobotBodyReading at_last;
  std::vector<Surprise> surprises;
};

Picked pick(simulation::RobotWorld& world, const ArmCycleOptions& options, GraspsToTry grasps) {
  Picked picked;
  ArmInWorld arm(world);
  CycleInWorld in_world(arm, options);
  picked.result = in_world.run(std::move(grasps), nullptr, [&] {
    picked.highest = std::max(picked.highest, world.body("thing").height);
  });
  for (int i = 0; i < 500; ++i) world.step();
  picked.at_last = world.body("thing");
  picked.surprises = in_world.cycle().surprises();
  return picked;
}

TEST_P(PlatformCycle, PicksABoxAndACan) {
  const std::pair<const char*, geometry::TriangleMesh> things[] = {
      {"box", simulation::make_standing_box({0.05, 0.05, 0.14})},
      {"can", simulation::make_can(0.027, 0.13)}};
  for (const auto& [name, mesh_W] : things) {
    SCOPED_TRACE(name);
    const planning::PlatformPlan made = planned.plan(mesh_W);
    ASSERT_FALSE(made.picks.empty()) << made.problem;
    EXPECT_EQ(made.outcome, grasp::PlanOutcome::kGraspable);
    ASSERT_TRUE(made.picks.front().move_W.has_value());
    simulation::RobotWorld world = world_of(mesh_W);
    const Eigen::Vector3d before = world.body("thing").X_WB.translation();
    const Picked picked = pick(world, reacting(), planned.to_try(made));
    EXPECT_TRUE(picked.result.success()) << picked.result.reason;
    EXPECT_EQ(picked.result.attempts, 1);
    EXPECT_GT(picked.highest, 0.1);
    const Eigen::Vector3d moved = picked.at_last.X_WB.translation() - before;
    EXPECT_LT((moved - *made.picks.front().move_W).head<2>().norm(), 0.03) << moved.transpose();
    EXPECT_LT(picked.at_last.height, 0.003);
    EXPECT_FALSE(picked.at_last.touches_robot);
    // A density is guessed, a weight is felt.
    const auto weight =
        std::find_if(picked.surprises.begin(), picked.surprises.end(),
                     [](const Surprise& s) { return s.kind == SurpriseKind::kLiftedWeight; });
    ASSERT_NE(weight, picked.surprises.end());
    EXPECT_NEAR(weight->felt, kMass * 9.81, 0.3);
  }
}

TEST_P(PlatformCycle, WhatIsNotThereSurprises) {
  const geometry::TriangleMesh mesh_W = simulation::make_standing_box({0.05, 0.05, 0.14});
  simulation::RobotWorld world = world_of(mesh_W);
  geometry::RigidTransform elsewhere = geometry::RigidTransform::Identity();
  elsewhere.translation() = Eigen::Vector3d(0.3, 0.5, world.body("thing").X_WB.translation().z());
  world.place_object("thing", elsewhere);
  ArmCycleOptions once = reacting();
  once.largest_attempts = 1;
  const Picked picked = pick(world, once, planned.to_try(planned.plan(mesh_W)));
  EXPECT_FALSE(picked.result.success());
  EXPECT_NE(picked.result.reason.find("closed on nothing"), std::string::npos)
      << picked.result.reason;
  EXPECT_LT(picked.highest, 0.01);
  EXPECT_TRUE(std::any_of(picked.surprises.begin(), picked.surprises.end(), [](const auto& s) {
    return s.kind == SurpriseKind::kFingersTouch && s.surprising;
  }));
}

// Jaws meet in the middle, and of a hand without pads nobody predicts where its motors stop.
class AdaptingPlatform : public PlatformCycle {};

// One that stands 2 cm beside its prediction: a fingertip comes down on it, or the fingers meet it
// one after the other. Without adapting it is held by its edge or, when it is heavy, lost.
TEST_P(AdaptingPlatform, PutsTheHandInTheMiddleOfWhatItMeets) {
  const geometry::TriangleMesh mesh_W = simulation::make_standing_box({0.05, 0.05, 0.14});
  const planning::PlatformPlan made = planned.plan(mesh_W);
  ASSERT_FALSE(made.picks.empty()) << made.problem;
  EXPECT_GE(made.picks.front().shifts.size(), 3u) << "nothing but the table is beside it";
  double height[2] = {0, 0};
  for (const int adaptations : {0, 2}) {
    simulation::RobotWorld world = world_of(mesh_W);
    geometry::RigidTransform beside = world.body("thing").X_WB;
    beside.translation().x() += 0.02;
    world.place_object("thing", beside);
    ArmCycleOptions once = reacting();
    once.largest_attempts = 1;
    once.adaptations = adaptations;
    const Picked picked = pick(world, once, planned.to_try(made));
    EXPECT_TRUE(picked.result.success()) << picked.result.reason;
    height[adaptations / 2] = picked.highest;
  }
  EXPECT_GE(height[1], height[0] - 0.002) << "as high as the hand: it does not hang from an edge";
  EXPECT_GT(height[1], 0.145);
}

// Plan and run, bit by bit, with a sensor's noise.
TEST_P(PlatformCycle, IsTheSameRunAgain) {
  const geometry::TriangleMesh mesh_W = simulation::make_can(0.027, 0.13);
  std::optional<Picked> first;
  for (int run = 0; run < 2; ++run) {
    simulation::RobotWorld world = world_of(mesh_W);
    Picked picked = pick(world, reacting(), planned.to_try(planned.plan(mesh_W)));
    ASSERT_TRUE(picked.result.success()) << picked.result.reason;
    if (!first) {
      first = std::move(picked);
      continue;
    }
    EXPECT_EQ(picked.at_last.X_WB.matrix(), first->at_last.X_WB.matrix());
    EXPECT_EQ(picked.highest, first->highest);
    ASSERT_EQ(picked.surprises.size(), first->surprises.size());
    for (std::size_t i = 0; i < picked.surprises.size(); ++i) {
      EXPECT_EQ(picked.surprises[i].felt, first->surprises[i].felt) << i;
    }
  }
}

TEST_P(PlatformCycle, WithoutGraspsItSaysWhy) {
  const planning::PlatformPlan none = planned.plan(simulation::make_standing_box({0.4, 0.4, 0.4}));
  EXPECT_TRUE(none.picks.empty());
  EXPECT_EQ(none.outcome, grasp::PlanOutcome::kUngraspable) << none.problem;
  simulation::RobotWorld world = world_of(simulation::make_standing_box({0.05, 0.05, 0.14}));
  const CycleResult result = pick(world, reacting(), planned.to_try(none)).result;
  EXPECT_FALSE(result.success());
  EXPECT_EQ(result.attempts, 0);
  EXPECT_EQ(result.reason, grasp::ungraspable_text(none.problem));
}

TEST_P(PlatformCycle, PlacesAndCountsOutOfRangeAreRefused) {
  planning::PlatformPlanOptions options = planned.plan_options();
  options.motions = 0;
  const surface::ObjectModel model =
      surface::model_of_mesh(simulation::make_standing_box({0.05, 0.05, 0.14}));
  EXPECT_THROW(planned.planner.plan(model, {}, {}, {}, planned.start, options),
               std::invalid_argument);
  options = planned.plan_options();
  options.place.given_W = Eigen::Vector2d(3, 0);
  const planning::PlatformPlan far =
      planned.planner.plan(model, {}, {}, {}, planned.start, options);
  EXPECT_TRUE(far.picks.empty());
  EXPECT_EQ(far.outcome, grasp::PlanOutcome::kUngraspable);
  EXPECT_GE(far.robustness, 0.5) << "the hand's grasps are told all the same";
  EXPECT_NE(far.problem.find(planning::kPlaceMend), std::string::npos) << far.problem;
}

INSTANTIATE_TEST_SUITE_P(Platforms, AdaptingPlatform, testing::Values("kr5_sdh"));
INSTANTIATE_TEST_SUITE_P(Platforms, PlatformCycle,
                         testing::Values("kr5_sdh", "kr5_pg70", "pa10_barrett"),
                         [](const auto& one) { return std::string(one.param); });

TEST(CycleInWorldTest, RefusesTimesThatAreNone) {
  const robot::Platform platform = robot::read_platform("config/robots/kr5_sdh.yaml");
  simulation::RobotWorld robot_world(platform, simulation::Scene());
  ArmInWorld world(robot_world);
  for (const double bad : {0.0, -1.0, std::nan("")}) {
    CycleInWorldOptions options;
    options.period = bad;
    EXPECT_THROW(CycleInWorld(world, {}, options), std::invalid_argument);
    options = {};
    options.time_limit = bad;
    EXPECT_THROW(CycleInWorld(world, {}, options), std::invalid_argument);
  }
}

}  // namespace
}  // namespace prehend::control
