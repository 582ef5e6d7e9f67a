#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "msgs/actions.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "tests/simulation/simulation_process.h"

namespace prehend {

/// A simulation of the KR5 with the SDH-2 in real time, as a process, and a node that hears its
/// joints and asks it to move.
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
    joints_ =
        node_->subscribe<msgs::JointState>("/joint_states", graph::QoS::queue(200),
                                           [this](const graph::Received<msgs::JointState>& m) {
                                             const std::lock_guard lock(mutex_);
                                             if (!states_.empty()) watch(states_.back(), *m);
                                             states_.push_back(*m);
                                           });
    truth_ =
        node_->subscribe<msgs::GroundTruth>("/ground_truth", graph::QoS::queue(100),
                                            [this](const graph::Received<msgs::GroundTruth>& m) {
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
    constexpr double kAcceleration = 12;  // rad/s^2, of ArmDriveOptions
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
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (std::chrono::steady_clock::now() < end) {
      {
        const std::lock_guard lock(mutex_);
        if (condition()) return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
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
    const auto outcome = arm_.send(goal).wait(std::chrono::seconds(40));
    EXPECT_TRUE(outcome.ok()) << outcome.error();
    return outcome.ok() ? *outcome : msgs::FollowTrajectoryResult();
  }

  void expect_refused(const msgs::FollowTrajectoryGoal& goal, const std::string& words) {
    const msgs::FollowTrajectoryResult result = follow(goal);
    EXPECT_FALSE(result.reached());
    EXPECT_THAT(result.reason(), ::testing::HasSubstr(words));
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

}  // namespace prehend
