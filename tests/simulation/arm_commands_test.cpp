// The simulation node's topic /arm/command: set points of a controller that interpolates.

#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "msgs/joints.pb.h"
#include "tests/simulation/robot_node.h"

namespace prehend {
namespace {

using namespace std::chrono_literals;
using graph::QoS;

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
    return states_.back().position(0) > start_[0] + 0.05;
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

}  // namespace
}  // namespace prehend
