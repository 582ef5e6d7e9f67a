// The simulation node with an arm and a hand: its topics, services and actions.

#include <chrono>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <mutex>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "msgs/actions.pb.h"
#include "msgs/convert/geometry.h"
#include "msgs/sensors.pb.h"
#include "tests/simulation/robot_node.h"

namespace prehend {
namespace {

using namespace std::chrono_literals;
using graph::QoS;
using ::testing::HasSubstr;

TEST_F(RobotNode, FollowsATrajectory) {
  const msgs::FollowTrajectoryResult result = follow(turn(0.4, 0.8));
  EXPECT_TRUE(result.reached()) << result.reason();
  EXPECT_NEAR(result.position(0), start_[0] + 0.4, 1e-9);
  EXPECT_LT(result.largest_error(), 0.02);
  EXPECT_TRUE(wait_until([&] {
    return std::abs(states_.back().position(0) - start_[0] - 0.4) < 1e-9 &&
           states_.back().velocity(0) == 0;
  }));
  const std::lock_guard lock(mutex_);
  EXPECT_EQ(states_.back().name(0), "arm_axis_1");
  EXPECT_THAT(states_.back().name(), ::testing::Contains("hand_thumb_distal"));
}

TEST_F(RobotNode, RefusesTrajectoriesThatCannotBeRight) {
  msgs::FollowTrajectoryGoal goal = turn(0.4, 1);
  goal.mutable_trajectory()->set_joint_name(2, "arm_axis_33");
  expect_refused(goal, "did you mean \"arm_axis_3\"?");
  goal = turn(0.4, 1);
  goal.mutable_trajectory()->set_joint_name(2, "arm_axis_2");
  expect_refused(goal, "named twice");
  goal = turn(0.4, 1);
  goal.mutable_trajectory()->mutable_points(0)->set_position(1, start_[1] + 0.1);
  expect_refused(goal, "plan from the arm's present positions");
  goal = turn(0.4, 1);
  goal.mutable_trajectory()->mutable_points(1)->set_position(
      3, std::numeric_limits<double>::quiet_NaN());
  expect_refused(goal, "no finite number");
  goal = turn(0.4, 1);
  goal.mutable_trajectory()->mutable_points(1)->set_time(0);
  expect_refused(goal, "times do not increase");
  expect_refused(turn(4, 10), "is outside");
  goal = turn(0.4, 1);
  goal.mutable_trajectory()->mutable_points(1)->set_velocity(0, 50);
  expect_refused(goal, "is faster than");
  goal = turn(0.4, 1);
  goal.mutable_trajectory()->clear_points();
  expect_refused(goal, "no points");
  goal = turn(0.4, 1);
  goal.add_path_tolerance(-1);
  expect_refused(goal, "path_tolerance");
  goal = turn(0.4, 1);
  goal.set_stop_on_contact(true);
  expect_refused(goal, "contact_force must be positive");
}

TEST_F(RobotNode, GivesUpAPathItCannotKeep) {
  msgs::FollowTrajectoryGoal goal = turn(0.5, 0.12);  // 8 rad/s at its middle
  const msgs::FollowTrajectoryResult result = follow(goal);
  EXPECT_FALSE(result.reached());
  EXPECT_THAT(result.reason(), HasSubstr("off the path"));
  EXPECT_GT(result.largest_error(), 0.05);
}

TEST_F(RobotNode, BrakesWhenCancelled) {
  auto goal = arm_.send(turn(1.2, 3));
  ASSERT_TRUE(wait_until([&] { return states_.back().velocity(0) > 0.3; }));
  goal.cancel();
  goal.wait(20s);
  ASSERT_TRUE(wait_until([&] { return states_.back().velocity(0) == 0; }));
  EXPECT_GT(position()[0], start_[0] + 0.05);
  EXPECT_LT(position()[0], start_[0] + 1.1);
}

TEST_F(RobotNode, BrakesForANewerTrajectoryThatBeginsWhereItThenStands) {
  const msgs::FollowTrajectoryGoal planned_before = turn(-0.2, 1);
  auto first = arm_.send(turn(1.2, 3));
  ASSERT_TRUE(wait_until([&] { return states_.back().position(0) > start_[0] + 0.1; }));
  const msgs::FollowTrajectoryResult second = follow(planned_before);
  first.wait(20s);
  // It stands elsewhere now.
  EXPECT_FALSE(second.reached());
  EXPECT_THAT(second.reason(), HasSubstr("starts"));
  ASSERT_TRUE(wait_until([&] { return states_.back().velocity(0) == 0; }));
  const double stands = position()[0];
  const msgs::FollowTrajectoryResult third = follow(turn(-0.2, 1));
  EXPECT_TRUE(third.reached()) << third.reason();
  EXPECT_NEAR(third.position(0), stands - 0.2, 1e-9);
}

TEST_F(RobotNode, StopsAtOnceWhenAsked) {
  auto goal = arm_.send(turn(1.2, 3));
  ASSERT_TRUE(wait_until([&] { return states_.back().velocity(0) > 0.3; }));
  auto stop = node_->client<msgs::Empty, msgs::Acknowledge>("/arm/stop");
  const auto answer = stop.call({}, 10s);
  ASSERT_TRUE(answer.ok()) << answer.error();
  EXPECT_TRUE(answer->success());
  const auto outcome = goal.wait(20s);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_FALSE(outcome->reached());
  ASSERT_TRUE(wait_until([&] { return states_.back().velocity(0) == 0; }));
}

TEST_F(RobotNode, MovesTheHand) {
  msgs::MoveHandGoal goal;
  goal.add_joint_name("hand_thumb_proximal");
  goal.add_joint_name("thumb_distal");  // the hand's own name does too
  goal.add_position(0.2);
  goal.add_position(0.1);
  goal.set_speed(0.5);
  const auto outcome = hand_.send(goal).wait(30s);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_TRUE(outcome->reached()) << outcome->reason();
  EXPECT_NEAR(outcome->position(0), 0.2, 0.02);
  EXPECT_NEAR(outcome->position(1), 0.1, 0.02);

  const auto refused = [&](const msgs::MoveHandGoal& bad, const char* words) {
    const auto answer = hand_.send(bad).wait(30s);
    ASSERT_TRUE(answer.ok()) << answer.error();
    EXPECT_FALSE(answer->reached());
    EXPECT_THAT(answer->reason(), HasSubstr(words));
  };
  msgs::MoveHandGoal bad = goal;
  bad.set_joint_name(0, "hand_thumb_proximall");
  refused(bad, "did you mean \"hand_thumb_proximal\"?");
  bad = goal;
  bad.set_position(0, 3);
  refused(bad, "is outside");
  bad = goal;
  bad.set_position(0, std::numeric_limits<double>::infinity());
  refused(bad, "not finite");
  bad = goal;
  bad.set_speed(0);
  refused(bad, "speed");
  bad = goal;
  bad.add_effort(1);
  refused(bad, "efforts");
  bad = goal;
  bad.mutable_joint_name()->RemoveLast();
  refused(bad, "2 positions for 1 joints");
}

class HandCommands : public RobotNode {
 protected:
  void SetUp() override {
    RobotNode::SetUp();
    commands_ = node_->advertise<msgs::JointCommand>("/hand/command", QoS::queue(100));
    ASSERT_TRUE(commands_.wait_for_subscribers(1, 10s));
    rest_ = thumb();
  }

  void send(msgs::JointCommand::Mode mode, double value,
            const std::string& joint = "thumb_proximal", std::int64_t stamp = 0) {
    msgs::JointCommand command;
    command.mutable_header()->set_stamp(stamp != 0 ? stamp : node_->clock().now());
    command.set_mode(mode);
    command.add_joint_name(joint);
    if (mode != msgs::JointCommand::STOP) command.add_value(value);
    commands_.publish(command);
  }
  /// As a stream does.
  void send_again(msgs::JointCommand::Mode mode, double value,
                  const std::string& joint = "thumb_proximal") {
    for (int i = 0; i < 5; ++i) {
      send(mode, value, joint);
      std::this_thread::sleep_for(10ms);
    }
  }

  // Of hand_thumb_proximal.
  static double of_thumb(const msgs::JointState& state, bool velocity = false) {
    for (int i = 0; i < state.name_size(); ++i) {
      if (state.name(i) != "hand_thumb_proximal") continue;
      return velocity ? state.velocity(i) : state.position(i);
    }
    return std::numeric_limits<double>::quiet_NaN();
  }
  double thumb() {
    const std::lock_guard lock(mutex_);
    return of_thumb(states_.back());
  }
  void wait_simulated(std::chrono::nanoseconds time) {
    std::int64_t end = 0;
    {
      const std::lock_guard lock(mutex_);
      end = states_.back().header().stamp() + time.count();
    }
    ASSERT_TRUE(wait_until([&] { return states_.back().header().stamp() > end; }));
  }
  int said(const std::string& words) const {
    std::ifstream in(output_);
    int count = 0;
    for (std::string line; std::getline(in, line);) count += line.find(words) != std::string::npos;
    return count;
  }

  graph::Publisher<msgs::JointCommand> commands_;
  double rest_ = 0;
};

TEST_F(HandCommands, AForgottenVelocityIsStoppedByTheWatchdog) {
  send(msgs::JointCommand::VELOCITY, 0.5);
  ASSERT_TRUE(wait_until([&] { return of_thumb(states_.back(), true) > 0.4; }));
  ASSERT_TRUE(wait_until([&] { return std::abs(of_thumb(states_.back(), true)) < 1e-3; }));
  // 0.2 s of 0.5 rad/s and braking; unwatched it would go on for seconds.
  EXPECT_GT(thumb(), rest_ + 0.05);
  EXPECT_LT(thumb(), rest_ + 0.2);
  EXPECT_EQ(said("no hand command for 0.2 s while moving: stopped"), 1);
}

TEST_F(HandCommands, WhatCannotBeIsRefusedOnceAndNothingMoves) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  send_again(msgs::JointCommand::VOLTAGE, 1);
  send_again(msgs::JointCommand::EFFORT, nan);
  send_again(msgs::JointCommand::POSITION, 9);
  send_again(msgs::JointCommand::VELOCITY, 1, "thumb_proximl");
  send_again(static_cast<msgs::JointCommand::Mode>(9), 1);
  ASSERT_TRUE(wait_until([&] { return said("unknown mode of a joint command") > 0; }));
  wait_simulated(300ms);
  EXPECT_NEAR(thumb(), rest_, 1e-3);
  EXPECT_EQ(said("/hand/command refused: 'hand_thumb_proximal' has no motor"), 1);
  EXPECT_EQ(said("'hand_thumb_proximal' is not finite"), 1);
  EXPECT_EQ(said("'hand_thumb_proximal' at 9.0000 is outside"), 1);
  EXPECT_EQ(said("did you mean \"hand_thumb_proximal\"?"), 1);
  EXPECT_EQ(said("unknown mode of a joint command"), 1);
}

TEST_F(HandCommands, ALaterCommandTakesOverFromAGoalAndAnEarlierIsIgnored) {
  msgs::MoveHandGoal goal;
  goal.add_joint_name("thumb_proximal");
  goal.add_position(rest_ + 1.2);
  goal.set_speed(0.2);
  goal.set_stamp(node_->clock().now());
  auto handle = hand_.send(goal);
  ASSERT_TRUE(wait_until([&] { return of_thumb(states_.back()) > rest_ + 0.05; }));
  for (int i = 0; i < 5; ++i) send(msgs::JointCommand::STOP, 0, "thumb_proximal", goal.stamp());
  ASSERT_TRUE(wait_until([&] { return of_thumb(states_.back()) > rest_ + 0.2; }));
  EXPECT_EQ(said("/hand/command ignored"), 1);
  send(msgs::JointCommand::STOP, 0, "thumb_proximal", goal.stamp() + 1);
  const auto outcome = handle.wait(20s);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_FALSE(outcome->reached());
  EXPECT_EQ(outcome->reason(), "stopped by /hand/command");
  ASSERT_TRUE(wait_until([&] { return std::abs(of_thumb(states_.back(), true)) < 1e-3; }));
  EXPECT_LT(thumb(), rest_ + 1);
}

TEST_F(RobotNode, TellsTheTruthOfItsObjects) {
  ASSERT_TRUE(wait_until([&] { return bodies_.bodies_size() == 3; }));
  const std::lock_guard lock(mutex_);
  EXPECT_EQ(bodies_.bodies(0).name(), "carton");
  EXPECT_TRUE(bodies_.bodies(0).touches_table());
}

}  // namespace
}  // namespace prehend
