#include "eval/grasp/platform_under_test.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "eval/grasp/in_reach.h"
#include "prehend/geometry/errors.h"
#include "prehend/simulation/shapes.h"

namespace prehend::eval {
namespace {

using control::SurpriseKind;

PlannerSetting on_truth() {
  PlannerSetting setting;
  setting.name = to_string(PlannedOn::kTruth);
  setting.planned_on = PlannedOn::kTruth;
  return setting;
}

int count_of(const GraspTrial& trial, SurpriseKind kind, bool surprising) {
  int count = 0;
  for (const auto& s : trial.surprises) count += s.kind == kind && s.surprising == surprising;
  return count;
}

TEST(PlatformUnderTest, LiftsWhatIsThereAndTellsWhatItFelt) {
  const PlatformUnderTest platform("config/robots/kr5_pg70.yaml");
  EXPECT_EQ(platform.name(), "kr5_pg70");
  const TrueObject truth{simulation::make_standing_box({0.04, 0.05, 0.12}), 0.2, {}};
  const GraspTrial trial = platform.grasp(belief_of(truth.mesh_W, {}), truth, on_truth(), nullptr);
  EXPECT_TRUE(trial.lifted_at_first()) << trial.problem << trial.outcome;
  EXPECT_EQ(trial.stage, "");
  EXPECT_GE(trial.best_robustness, 0.5);
  EXPECT_LT(trial.contact_error, 1e-3) << "planned on the truth";
  EXPECT_LT(trial.slip, 0.005);
  // Its pads feel, so that what they feel is compared.
  EXPECT_EQ(count_of(trial, SurpriseKind::kTactileSum, true) +
                count_of(trial, SurpriseKind::kTactileSum, false),
            1);
  EXPECT_EQ(count_of(trial, SurpriseKind::kHeldAfterLift, false), 1);
}

// The gripper that regulates its grip, on its stage: another world and another hand port, the same
// way.
TEST(PlatformUnderTest, LiftsByAGripperThatIsMovedThroughItsDrive) {
  const PlatformUnderTest platform("config/robots/stage_pg70.yaml");
  const TrueObject truth{simulation::make_standing_box({0.04, 0.05, 0.12}), 0.2, {}};
  const GraspTrial trial = platform.grasp(belief_of(truth.mesh_W, {}), truth, on_truth(), nullptr);
  EXPECT_TRUE(trial.lifted_at_first()) << trial.problem << trial.outcome;
  EXPECT_EQ(trial.stage, "");
  EXPECT_LT(trial.slip, 0.005);
  EXPECT_GT(trial.grasp_seconds, 0);
  EXPECT_LT(std::abs(trial.opening_error), 0.002) << "planned on the truth";
  EXPECT_LT(std::abs(trial.area_error), 0.5);
  EXPECT_EQ(count_of(trial, SurpriseKind::kOpeningAtContact, false), 1);
  EXPECT_EQ(count_of(trial, SurpriseKind::kTactileSum, false), 1);
}

// What is believed to be there is not: every attempt fails where the fingers close, with a
// surprise.
TEST(PlatformUnderTest, SaysAtWhichStageItFailed) {
  const PlatformUnderTest platform("config/robots/kr5_sdh.yaml");
  const geometry::TriangleMesh box_W = simulation::make_standing_box({0.05, 0.05, 0.14});
  geometry::RigidTransform elsewhere = geometry::RigidTransform::Identity();
  elsewhere.translation() = Eigen::Vector3d(0.3, 0.4, 0);
  const TrueObject truth{geometry::transformed(box_W, elsewhere), 0.2, {}};
  int looks = 0;
  const GraspTrial trial = platform.grasp(
      belief_of(box_W, {}), truth, on_truth(),
      [&](const geometry::RigidTransform& X_moved, const belief::Attempt& attempt) -> Belief {
        EXPECT_LT(X_moved.translation().norm(), 0.01);
        // The hand went through where it was believed to be, and touched nothing.
        EXPECT_EQ(attempt.size(), 1);
        EXPECT_GT(attempt.front().free_way.size(), 3);
        EXPECT_TRUE(attempt.front().contacts.empty());
        if (++looks == 1) return belief_of(box_W, {});
        throw geometry::InputError("fog", "wait");
      });
  EXPECT_FALSE(trial.lifted);
  EXPECT_EQ(trial.attempts, 3);
  EXPECT_EQ(trial.plans, 2);
  EXPECT_EQ(looks, 2);
  EXPECT_EQ(trial.stage, "grasp");
  EXPECT_NE(trial.outcome.find("closed on nothing"), std::string::npos) << trial.outcome;
  EXPECT_EQ(count_of(trial, SurpriseKind::kFingersTouch, true), 3);
}

TEST(PlatformUnderTest, WhatNoHandCanHoldEndsAtThePlan) {
  const PlatformUnderTest platform("config/robots/kr5_pg70.yaml");
  const TrueObject truth{simulation::make_standing_box({0.3, 0.3, 0.3}), 0.2, {}};
  const GraspTrial trial = platform.grasp(belief_of(truth.mesh_W, {}), truth, on_truth(), nullptr);
  EXPECT_EQ(trial.grasps, 0);
  EXPECT_EQ(trial.stage, "plan");
  EXPECT_NE(trial.problem.find("cannot be grasped"), std::string::npos);
}

TEST(InReach, PlatformsThatReachTheMiddleStayAndOthersAreMoved) {
  const robot::Platform at_place = robot::read_platform("config/robots/kr5_sdh.yaml");
  EXPECT_EQ(in_reach(at_place).X_WB.matrix(), at_place.X_WB.matrix());
  robot::Platform far = at_place;
  far.X_WB.translation() += Eigen::Vector3d(4, -7, 0);
  const robot::Platform moved = in_reach(far);
  EXPECT_EQ(moved.X_WB.linear(), far.X_WB.linear());
  EXPECT_EQ(moved.X_WB.translation().z(), far.X_WB.translation().z());
  const double distance = moved.X_WB.translation().head<2>().norm();
  EXPECT_GT(distance, 0.3) << "not under the arm's base";
  EXPECT_LT(distance, 0.85) << "the KR5 sixx R850 reaches 0.85 m";
  EXPECT_EQ(in_reach(moved).X_WB.matrix(), moved.X_WB.matrix());
  far.X_WB.translation().z() = 3;
  EXPECT_THROW(in_reach(far), geometry::InputError);
}

}  // namespace
}  // namespace prehend::eval
