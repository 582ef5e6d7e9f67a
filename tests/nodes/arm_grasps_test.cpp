// From the message of a grasp to what the cycle of arm and hand executes.

#include "nodes/grasp_cycle/arm_grasps.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/grasp.h"
#include "prehend/geometry/errors.h"

namespace prehend::nodes {
namespace {

using ::testing::HasSubstr;

msgs::Grasp arm_grasp() {
  msgs::Grasp grasp;
  *grasp.mutable_x_wg() = convert::to_message(geometry::RigidTransform::Identity());
  auto& segment = *grasp.add_arm();
  segment.set_name("reach");
  segment.mutable_trajectory()->add_joint_name("arm_1");
  for (const char* joint : {"hand_a", "hand_b"}) grasp.add_hand_joint_name(joint);
  for (const double open : {0.1, 0.3}) grasp.add_open_position(open);
  for (const double closed : {0.8, 0.3}) grasp.add_closed_position(closed);
  grasp.set_score(0.7);
  return grasp;
}

TEST(ArmGrasps, TakesRatesAndLimitsOfThePlan) {
  msgs::Grasp grasp = arm_grasp();
  for (const double rate : {0.5, 0.0}) grasp.add_closing_rate(rate);
  for (int i = 0; i < 2; ++i) grasp.add_least_position(-1);
  for (int i = 0; i < 2; ++i) grasp.add_largest_position(1);
  grasp.set_robustness(0.9);
  ASSERT_TRUE(is_executable(grasp));
  const control::ArmGrasp made = from_message(grasp);
  EXPECT_TRUE(made.hand.at(0.2).isApprox(Eigen::Vector2d(0.9, 0.3)));
  EXPECT_TRUE(made.hand.at(2).isApprox(Eigen::Vector2d(1, 0.3)));
  EXPECT_EQ(control::described(made, 3),
            "grasp 3 (score 0.70, held in 90 % of the disturbed trials)");
}

TEST(ArmGrasps, PlansWithoutThemCloseWhatMoves) {
  const control::ArmGrasp made = from_message(arm_grasp());
  EXPECT_TRUE(made.hand.at(0.5).isApprox(Eigen::Vector2d(1.3, 0.3)));
  EXPECT_EQ(control::described(made, 0), "grasp 0 (score 0.70, robustness not assessed)");
}

TEST(ArmGrasps, RefusesWhatDoesNotBelongTogether) {
  msgs::Grasp grasp = arm_grasp();
  grasp.add_closed_position(1);
  EXPECT_FALSE(is_executable(grasp));
  grasp = arm_grasp();
  grasp.add_closing_rate(1);
  EXPECT_THROW(from_message(grasp), geometry::InputError);
  grasp = arm_grasp();
  grasp.set_closed_position(0, std::nan(""));
  EXPECT_THROW(from_message(grasp), geometry::InputError);
}

TEST(ArmGrasps, SaysWhereTheObjectGoes) {
  msgs::Grasp grasp = arm_grasp();
  EXPECT_EQ(destination(grasp), "only lifted");
  *grasp.mutable_move() = convert::to_message(Eigen::Vector3d(0.3, -0.4, 0));
  EXPECT_EQ(destination(grasp), "put 0.50 m away");
  *grasp.mutable_move() = convert::to_message(Eigen::Vector3d(0, 0, 0));
  EXPECT_THAT(destination(grasp), HasSubstr("no free place"));
}

// Regression: a grasp that was never assessed said 1 in one planner's messages, 0 in the other's.
TEST(GraspMessage, RobustnessThatWasNotAssessedStaysSo) {
  grasp::Grasp grasp;
  EXPECT_EQ(grasp.robustness, -1);
  grasp.pregrasp_opening = grasp.pregrasp_distance = grasp.grasp_force = 1;
  const msgs::Grasp message = convert::to_message(grasp);
  EXPECT_FALSE(message.has_robustness());
  EXPECT_EQ(convert::from_message(message).robustness, -1);
  grasp.robustness = 0;
  EXPECT_TRUE(convert::to_message(grasp).has_robustness());
  EXPECT_EQ(convert::from_message(convert::to_message(grasp)).robustness, 0);
}

}  // namespace
}  // namespace prehend::nodes
