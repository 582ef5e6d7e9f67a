// The simulation node with an arm and a hand: its topics, services and actions.

#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "msgs/actions.pb.h"
#include "msgs/convert/geometry.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "tests/simulation/simulation_process.h"

namespace prehend {
namespace {

using namespace std::chrono_literals;
using graph::QoS;
using ::testing::HasSubstr;

constexpr double kAcceleration = 12;  // rad/s^2, of ArmDriveOptions

class RobotNode : public ::testing::Test {
 protected:
  RobotNode()
      : output_(std::filesystem::temp_directory_path() /
                ("prehend_robot_" + std::to_string(getpid()) + ".log")),
        registry_({.endpoint = "tcp://127.0.0.1:*"}) {}

  void SetUp() override {
    simulation_ =
        start_simulation({"--registry", registry_.endpoint(), "--param", "speed:=1", "--param",
                          "camera:=false", "--param", "scene:=config/scenes/demo.yaml", "--param",
                          "robot:=config/robots/kr5_sdh.yaml"},
                         output_);
    graph::NodeOptions options;
    options.name = "tester";
    options.registry = registry_.endpoint();
    node_ = std::make_unique<graph::Node>(options);
    joints_ = node_->subscribe<msgs::JointState>(
        "/joint_states", QoS::queue(200), [this](const graph::Received<msgs::JointState>& m) {
          const std::lock_guard lock(mutex_);
          if (!states_.empty()) watch(states_.back(), *m);
          states_.push_back(*m);
        });
    truth_ = node_->subscribe<msgs::GroundTruth>(
        "/ground_truth", QoS::queue(100), [this](const graph::Received<msgs::GroundTruth>& m) {
          const std::lock_guard lock(mutex_);
          bodies_ = *m;
        });
    arm_ = node_->action_client<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                                msgs::FollowTrajectoryResult>("/arm/follow");
    hand_ = node_->action_client<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult>(
        "/hand/move");
    node_->spin_in_background();
    ASSERT_TRUE(wait_until([this] { return !states_.empty(); }));
    start_ = position();
  }

  void TearDown() override {
    node_.reset();
    kill(simulation_, SIGTERM);
    EXPECT_EQ(exit_code(simulation_), 0);
    std::filesystem::remove(output_);
    EXPECT_LT(sharpest_, kAcceleration * 1.02) << "of any joint of the arm";
  }

  // The arm's joints keep their acceleration limit whatever is asked.
  void watch(const msgs::JointState& before, const msgs::JointState& now) {
    const double h = 1e-9 * static_cast<double>(now.header().stamp() - before.header().stamp());
    for (int i = 0; i < 6; ++i) {
      sharpest_ = std::max(sharpest_, std::abs(now.velocity(i) - before.velocity(i)) / h);
    }
  }

  bool wait_until(const std::function<bool()>& condition) {
    const auto end = std::chrono::steady_clock::now() + 30s;
    while (std::chrono::steady_clock::now() < end) {
      {
        const std::lock_guard lock(mutex_);
        if (condition()) return true;
      }
      std::this_thread::sleep_for(5ms);
    }
    return false;
  }

  std::vector<double> position() {
    const std::lock_guard lock(mutex_);
    return {states_.back().position().begin(), states_.back().position().begin() + 6};
  }

  /// From where the arm stands, joint 1 by `way` in `duration`, from and to a stand.
  msgs::FollowTrajectoryGoal turn(double way, double duration) {
    msgs::FollowTrajectoryGoal goal;
    const std::vector<double> from = position();
    for (int i = 1; i <= 6; ++i) {
      goal.mutable_trajectory()->add_joint_name("arm_axis_" + std::to_string(i));
    }
    for (const double share : {0.0, 1.0}) {
      msgs::JointTrajectoryPoint& point = *goal.mutable_trajectory()->add_points();
      point.set_time(share * duration);
      for (int i = 0; i < 6; ++i) {
        point.add_position(from[static_cast<std::size_t>(i)] + (i == 0 ? share * way : 0.0));
        point.add_velocity(0);
      }
    }
    return goal;
  }

  msgs::FollowTrajectoryResult follow(const msgs::FollowTrajectoryGoal& goal) {
    const auto outcome = arm_.send(goal).wait(40s);
    EXPECT_TRUE(outcome.ok()) << outcome.error();
    return outcome.ok() ? *outcome : msgs::FollowTrajectoryResult();
  }

  void expect_refused(const msgs::FollowTrajectoryGoal& goal, const std::string& words) {
    const msgs::FollowTrajectoryResult result = follow(goal);
    EXPECT_FALSE(result.reached());
    EXPECT_THAT(result.reason(), HasSubstr(words));
    EXPECT_EQ(position(), start_) << "nothing moved";
  }

  std::string output_;
  graph::Registry registry_;
  pid_t simulation_ = -1;
  std::unique_ptr<graph::Node> node_;
  graph::Subscription joints_, truth_;
  graph::ActionClient<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                      msgs::FollowTrajectoryResult>
      arm_;
  graph::ActionClient<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult> hand_;
  std::mutex mutex_;
  std::vector<msgs::JointState> states_;
  msgs::GroundTruth bodies_;
  std::vector<double> start_;
  double sharpest_ = 0;  // rad/s^2
};

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

class ArmCommands : public RobotNode {
 protected:
  void SetUp() override {
    RobotNode::SetUp();
    commands_ = node_->advertise<msgs::JointCommand>("/arm/command", QoS::queue(100));
    ASSERT_TRUE(commands_.wait_for_subscribers(1, 10s));
  }
  /// A set point of all joints: where it began, and joint 1 by `way` from there.
  msgs::JointCommand set_point(double way) const {
    msgs::JointCommand command;
    command.set_mode(msgs::JointCommand::POSITION);
    for (int i = 0; i < 6; ++i) {
      command.add_joint_name("arm_axis_" + std::to_string(i + 1));
      command.add_value(start_[static_cast<std::size_t>(i)] + (i == 0 ? way : 0));
    }
    return command;
  }
  bool is_said(const std::string& words) {
    return wait_until([&] {
      std::ifstream file(output_);
      return std::string(std::istreambuf_iterator<char>(file), {}).find(words) != std::string::npos;
    });
  }
  bool stands() {
    return wait_until([&] { return states_.back().velocity(0) == 0; });
  }
  graph::Publisher<msgs::JointCommand> commands_;
};

TEST_F(ArmCommands, MoveTheArmWhileTheyComeAndBrakeItWhenTheyCease) {
  // Far: it goes there within its limits, and is on its way when they cease.
  ASSERT_TRUE(wait_until([&] {
    commands_.publish(set_point(2));
    return states_.back().position(0) > start_[0] + 0.02;
  }));
  EXPECT_TRUE(is_said("no arm command for 0.2 s while moving: stopped"));
  ASSERT_TRUE(stands());
  EXPECT_LT(position()[0], start_[0] + 1.95);
}

TEST_F(ArmCommands, BelongToWhoAskedLast) {
  auto goal = arm_.send(turn(1.2, 6));
  ASSERT_TRUE(wait_until([&] { return states_.back().position(0) > start_[0] + 0.1; }));
  commands_.publish(set_point(0.3));
  const auto outcome = goal.wait(20s);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_FALSE(outcome->reached());
  EXPECT_EQ(outcome->reason(), "stopped before the goal");
  for (int i = 0; i < 300 && std::abs(position()[0] - start_[0] - 0.3) > 1e-4; ++i) {
    commands_.publish(set_point(0.3));
    std::this_thread::sleep_for(10ms);
  }
  EXPECT_NEAR(position()[0], start_[0] + 0.3, 1e-4);
  EXPECT_TRUE(is_said("/arm/command moves the arm"));
  ASSERT_TRUE(stands());
  const msgs::FollowTrajectoryResult result = follow(turn(-0.2, 1));
  EXPECT_TRUE(result.reached()) << result.reason();
  commands_.publish(set_point(1));
  ASSERT_TRUE(wait_until([&] { return states_.back().velocity(0) > 0; }));
  msgs::JointCommand stop;
  stop.set_mode(msgs::JointCommand::STOP);
  commands_.publish(stop);
  ASSERT_TRUE(stands());
  EXPECT_LT(position()[0], start_[0] + 0.9);
}

TEST_F(ArmCommands, ThatCannotBeRightMoveNothingAndAreSaid) {
  const auto refused = [&](const msgs::JointCommand& command, const std::string& words) {
    commands_.publish(command);
    EXPECT_TRUE(is_said("/arm/command refused: " + words)) << words;
  };
  msgs::JointCommand bad = set_point(0.3);
  bad.set_value(0, 9);
  refused(bad, "the set point: joint 'arm_axis_1' at 9.0000 is outside");
  bad.set_value(0, std::numeric_limits<double>::quiet_NaN());
  refused(bad, "point 0 has a position that is no finite number");
  bad = set_point(0.3);
  bad.mutable_value()->RemoveLast();
  refused(bad, "it has not one value a joint");
  bad = set_point(0.3);
  bad.set_joint_name(0, "arm_axis_11");
  refused(bad, "the arm has no joint 'arm_axis_11'");
  bad = set_point(0.3);
  bad.set_mode(msgs::JointCommand::VELOCITY);
  refused(bad, "an arm takes POSITION and STOP alone");
  EXPECT_EQ(position(), start_);
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
