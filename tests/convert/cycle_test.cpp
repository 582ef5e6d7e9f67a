// From the message of a grasp to what the cycle of arm and hand executes.

#include "msgs/convert/cycle.h"

#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "msgs/convert/decision.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/grasp.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

msgs::Grasp arm_grasp() {
  msgs::Grasp grasp;
  *grasp.mutable_x_wg() = to_message(geometry::RigidTransform::Identity());
  auto& segment = *grasp.add_arm();
  segment.set_kind(msgs::ArmSegment::REACH);
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
  grasp.set_pregrasp_distance(0.08);
  ASSERT_TRUE(has_arm_motion(grasp));
  const control::ArmGrasp made = arm_grasp_from_message(grasp);
  EXPECT_EQ(made.approach_length, 0.08);
  EXPECT_TRUE(made.hand.at(0.2).isApprox(Eigen::Vector2d(0.9, 0.3)));
  EXPECT_TRUE(made.hand.at(2).isApprox(Eigen::Vector2d(1, 0.3)));
  EXPECT_EQ(control::described(made, 3),
            "grasp 3 (score 0.70, held in 90 % of the disturbed trials)");
}

TEST(ArmGrasps, AreTheSameThereAndBack) {
  control::ArmGrasp grasp;
  control::JointTrajectory path{{"arm_1"}, {{0, {0.1}, {0}, {0}}, {0.02, {0.3}, {0}, {1.5}}}};
  grasp.segments = {{motion::SegmentKind::kReach, path},
                    {motion::SegmentKind::kLift, control::reversed(path)}};
  grasp.hand_joints = {"hand_a", "hand_b"};
  grasp.hand = {Eigen::Vector2d(0.1, 0.3), Eigen::Vector2d(0.8, 0.3), Eigen::Vector2d(1, 0),
                Eigen::Vector2d(-1, -2), Eigen::Vector2d(1, 2)};
  grasp.effort = 0.4;
  grasp.place_share = 0.7;
  grasp.place_length = 0.2;
  grasp.largest_effort = {2, 3};
  grasp.segments.insert(grasp.segments.begin() + 1, {motion::SegmentKind::kApproach, path});
  grasp.shifts = {{{0, 0.02, 0}, {0.1}}, {{0, -0.01, 0}, {-0.2}}};
  grasp.fingertips = {Eigen::Matrix3Xd::Random(3, 2), {1, -1}};
  msgs::Grasp message;
  *message.mutable_x_wg() = to_message(geometry::RigidTransform::Identity());
  add_motion(grasp, &message);
  ASSERT_TRUE(has_arm_motion(message));
  const control::ArmGrasp back = arm_grasp_from_message(message);
  ASSERT_EQ(back.segments.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(back.segments[i].first, grasp.segments[i].first);
    EXPECT_EQ(back.segments[i].second.joints, path.joints);
    ASSERT_EQ(back.segments[i].second.points.size(), 2u);
    EXPECT_EQ(back.segments[i].second.points[1].position,
              grasp.segments[i].second.points[1].position);
  }
  EXPECT_EQ(back.place_share, 0.7);
  EXPECT_EQ(back.place_length, 0.2);
  message.set_place_share(0);
  EXPECT_EQ(arm_grasp_from_message(message).place_share, 1) << "at its end";
  for (const double none : {-0.1, 1.1, std::nan("")}) {
    message.set_place_share(none);
    EXPECT_THROW(arm_grasp_from_message(message), geometry::InputError);
  }
  EXPECT_EQ(back.hand_joints, grasp.hand_joints);
  EXPECT_EQ(back.hand.closed, grasp.hand.closed);
  EXPECT_EQ(back.hand.rate, grasp.hand.rate);
  EXPECT_EQ(back.hand.lower, grasp.hand.lower);
  EXPECT_EQ(back.hand.upper, grasp.hand.upper);
  EXPECT_EQ(back.effort, 0.4);
  EXPECT_EQ(back.largest_effort, grasp.largest_effort);
  ASSERT_EQ(back.shifts.size(), 2u);
  EXPECT_EQ(back.shifts[1].way_W, grasp.shifts[1].way_W);
  EXPECT_EQ(back.shifts[1].offsets, grasp.shifts[1].offsets);
  EXPECT_EQ(back.fingertips.ways, grasp.fingertips.ways);
  EXPECT_EQ(back.fingertips.finger, grasp.fingertips.finger);
  EXPECT_EQ(back.stops.size(), 0) << "no simulated hand has said where it stops";
  msgs::Grasp bad = message;
  bad.mutable_shift(0)->add_offset(0.1);
  EXPECT_THROW(arm_grasp_from_message(bad), geometry::InputError) << "of two joints of one";
  bad = message;
  bad.mutable_shift(0)->set_offset(0, std::nan(""));
  EXPECT_THROW(arm_grasp_from_message(bad), geometry::InputError);
  bad = message;
  bad.mutable_fingertip_way()->RemoveLast();
  EXPECT_THROW(arm_grasp_from_message(bad), geometry::InputError);
}

TEST(ArmGrasps, PlansWithoutThemCloseWhatMoves) {
  const control::ArmGrasp made = arm_grasp_from_message(arm_grasp());
  EXPECT_TRUE(made.hand.at(0.5).isApprox(Eigen::Vector2d(1.3, 0.3)));
  EXPECT_EQ(control::described(made, 0), "grasp 0 (score 0.70, robustness not assessed)");
}

TEST(ArmGrasps, ArePredictedToCloseAsFarAsTheSimulatedHand) {
  msgs::Grasp grasp = arm_grasp();
  EXPECT_EQ(arm_grasp_from_message(grasp).closure, 0);
  grasp.mutable_predicted()->set_contact_area(3e-4);
  grasp.mutable_predicted()->set_tactile_sum(12);
  for (const double position : {0.9, 0.3}) grasp.mutable_predicted()->add_stop_position(position);
  const control::ArmGrasp made = arm_grasp_from_message(grasp);
  EXPECT_NEAR(made.closure, 0.1, 1e-12);
  EXPECT_EQ(made.contact_area, 3e-4);
  EXPECT_EQ(made.tactile_sum, 12);
}

TEST(ArmGrasps, RefusesWhatDoesNotBelongTogether) {
  msgs::Grasp grasp = arm_grasp();
  grasp.add_closed_position(1);
  EXPECT_FALSE(has_arm_motion(grasp));
  grasp = arm_grasp();
  grasp.add_closing_rate(1);
  EXPECT_THROW(arm_grasp_from_message(grasp), geometry::InputError);
  grasp = arm_grasp();
  grasp.set_closed_position(0, std::nan(""));
  EXPECT_THROW(arm_grasp_from_message(grasp), geometry::InputError);
  for (const double length : {-0.08, std::nan("")}) {
    grasp = arm_grasp();
    grasp.set_pregrasp_distance(length);
    EXPECT_THROW(arm_grasp_from_message(grasp), geometry::InputError);
  }
  grasp = arm_grasp();
  grasp.mutable_predicted()->add_stop_position(0.9);
  EXPECT_THROW(arm_grasp_from_message(grasp), geometry::InputError) << "of one joint of two";
  grasp.mutable_predicted()->add_stop_position(0.3);
  grasp.mutable_predicted()->set_stop_position(0, std::nan(""));
  EXPECT_THROW(arm_grasp_from_message(grasp), geometry::InputError);
}

// Where an arm would have gone along a segment of an older sender, or a newer one.
TEST(ArmGrasps, RefusesSegmentsOfAnUnknownKind) {
  msgs::Grasp grasp = arm_grasp();
  for (const int kind : {0, 7, -1}) {
    grasp.mutable_arm(0)->set_kind(static_cast<msgs::ArmSegment::Kind>(kind));
    EXPECT_THAT([&] { arm_grasp_from_message(grasp); },
                testing::ThrowsMessage<geometry::InputError>(testing::AllOf(
                    testing::HasSubstr(fmt::format("unknown ({})", kind)),
                    testing::HasSubstr("Mend or update the node that published it"))));
  }
}

TEST(Advice, IsTheBestOfAPlansChoices) {
  msgs::GraspPlan plan;
  EXPECT_EQ(advice_of(plan).act, control::Advice::Act::kGrasp) << "nothing is known";
  plan.add_grasps();
  plan.add_grasps();
  add_choices({{planning::Act::kTouch, 1, 0.9, 80, "feel it"},
               {planning::Act::kGrasp, 0, 0.5, 40, "grasp it now"}},
              &plan);
  ASSERT_EQ(plan.choices_size(), 2);
  EXPECT_EQ(plan.choices(1).worth(), 40);
  const control::Advice advice = advice_of(plan);
  EXPECT_EQ(advice.act, control::Advice::Act::kTouch);
  EXPECT_EQ(advice.grasp, 1);
  EXPECT_EQ(advice.why, "feel it");
  plan.mutable_choices(0)->set_act(msgs::Choice::GIVE_UP);
  EXPECT_EQ(advice_of(plan).act, control::Advice::Act::kGiveUp);
  plan.mutable_choices(0)->set_act(msgs::Choice::LOOK);
  EXPECT_EQ(advice_of(plan).act, control::Advice::Act::kGrasp);
}

TEST(Advice, ThatMakesNoSenseIsRefused) {
  msgs::GraspPlan plan;
  msgs::Choice& choice = *plan.add_choices();
  EXPECT_THROW(advice_of(plan), geometry::InputError) << "it names no act";
  choice.set_act(static_cast<msgs::Choice::Act>(9));
  EXPECT_THROW(advice_of(plan), geometry::InputError);
  choice.set_act(msgs::Choice::TOUCH);
  EXPECT_THROW(advice_of(plan), geometry::InputError) << "there are no grasps";
  plan.add_grasps();
  EXPECT_NO_THROW(advice_of(plan));
  choice.set_grasp(-1);
  EXPECT_THROW(advice_of(plan), geometry::InputError);
}

TEST(Surprises, TravelWithTheirKind) {
  control::Surprise surprise;
  surprise.kind = control::SurpriseKind::kLiftedWeight;
  surprise.predicted = 3;
  surprise.felt = 5;
  surprise.surprising = true;
  const msgs::Surprise message = to_message(surprise, 7);
  EXPECT_EQ(message.kind(), msgs::Surprise::LIFTED_WEIGHT);
  EXPECT_EQ(message.felt(), 5);
  EXPECT_EQ(message.header().stamp(), 7);
}

TEST(JointPaths, AreTheSameThereAndBack) {
  control::JointTrajectory path;
  path.joints = {"a", "b"};
  path.points = {{0, {1, 2}, {0, 0}, {}}, {0.5, {3, 4}, {0.1, 0.2}, {5, 6}}};
  const control::JointTrajectory back = from_message(to_message(path));
  EXPECT_EQ(back.joints, path.joints);
  ASSERT_EQ(back.points.size(), 2u);
  EXPECT_EQ(back.points[1].position, path.points[1].position);
  EXPECT_EQ(back.points[1].acceleration, path.points[1].acceleration);
  EXPECT_TRUE(back.points[0].acceleration.empty());
}

// Regression: a grasp that was never assessed said 1 in one planner's messages, 0 in the other's.
TEST(GraspMessage, RobustnessThatWasNotAssessedStaysSo) {
  grasp::Grasp grasp;
  EXPECT_EQ(grasp.robustness, -1);
  EXPECT_FALSE(to_message(grasp, robot::HandModel()).has_robustness());
  grasp.robustness = 0;
  EXPECT_TRUE(to_message(grasp, robot::HandModel()).has_robustness());
}

}  // namespace
}  // namespace prehend::convert
