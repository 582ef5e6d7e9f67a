#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "msgs/joints.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "tests/launch/child_program.h"
#include "tests/simulation/simulation_process.h"

namespace prehend::testing {

/// A simulated robot in a graph of its own, and a node that hears its joints.
class JoggedRobot {
 public:
  explicit JoggedRobot(const std::string& platform, const std::vector<std::string>& more = {})
      : output_(folder_.path("simulation.log")), registry_({.endpoint = "tcp://127.0.0.1:*"}) {
    std::vector<std::string> words{"--registry", registry_.endpoint(),
                                   "--param",    "camera:=false",
                                   "--param",    "robot:=config/robots/" + platform + ".yaml",
                                   "--param",    "robot_home:=home"};
    words.insert(words.end(), more.begin(), more.end());
    simulation_ = start_simulation(words, output_);
    graph::NodeOptions options;
    options.name = "tester";
    options.registry = registry_.endpoint();
    node_ = std::make_unique<graph::Node>(options);
    joints_ = node_->subscribe<msgs::JointState>("/joint_states", graph::QoS::latest(),
                                                 [this](const auto& message) {
                                                   const std::lock_guard lock(mutex_);
                                                   state_ = *message;
                                                 });
    gripper_ = node_->subscribe<msgs::GripperState>("/gripper/state", graph::QoS::latest(),
                                                    [this](const auto& message) {
                                                      const std::lock_guard lock(mutex_);
                                                      opening_ = message->opening();
                                                    });
    node_->spin_in_background();
    EXPECT_TRUE(eventually([this] { return state().name_size() > 0; }, std::chrono::seconds(30)))
        << said();
  }
  ~JoggedRobot() {
    node_.reset();
    kill(simulation_, SIGTERM);
    EXPECT_EQ(exit_code(simulation_), 0) << said();
  }

  const std::string& registry() const { return registry_.endpoint(); }
  graph::Node& node() { return *node_; }
  std::string said() const { return text_of_file(output_); }
  msgs::JointState state() const {
    const std::lock_guard lock(mutex_);
    return state_;
  }
  double opening() const {
    const std::lock_guard lock(mutex_);
    return opening_;
  }
  double position(const std::string& joint) const { return of(joint, true); }
  double velocity(const std::string& joint) const { return of(joint, false); }
  bool stands() const {
    return eventually([this] {
      const msgs::JointState now = state();
      return std::all_of(now.velocity().begin(), now.velocity().end(),
                         [](double v) { return std::abs(v) < 1e-3; });
    });
  }

 private:
  double of(const std::string& joint, bool position) const {
    const msgs::JointState now = state();
    for (int i = 0; i < now.name_size(); ++i) {
      if (now.name(i) == joint) return position ? now.position(i) : now.velocity(i);
    }
    ADD_FAILURE() << "no joint " << joint;
    return 0;
  }

  ScratchDirectory folder_;
  std::string output_;
  graph::Registry registry_;
  pid_t simulation_ = -1;
  mutable std::mutex mutex_;
  msgs::JointState state_;
  double opening_ = -1;
  std::unique_ptr<graph::Node> node_;
  graph::Subscription joints_, gripper_;
};

}  // namespace prehend::testing
