#include "drivers/kuka_rsi/emulator/graph_arm.h"

#include <algorithm>
#include <utility>

namespace prehend::drivers::kuka_rsi {

GraphArm::GraphArm(graph::Node& node, std::vector<std::string> joints)
    : node_(node),
      joints_(std::move(joints)),
      publisher_(node.advertise<msgs::JointCommand>("/world/arm/command", graph::QoS::queue(10))),
      subscription_(node.subscribe<msgs::JointState>(
          "/world/joint_states", graph::QoS::queue(10),
          [this](const graph::Received<msgs::JointState>& state) { take(*state); })) {}

void GraphArm::take(const msgs::JointState& state) {
  const std::lock_guard lock(mutex_);
  std::size_t found = 0;
  for (int i = 0; i < std::min(state.name_size(), state.position_size()); ++i) {
    const auto joint = std::find(joints_.begin(), joints_.end(), state.name(i));
    if (joint == joints_.end()) continue;
    actual_[static_cast<std::size_t>(joint - joints_.begin())] = state.position(i);
    ++found;
  }
  is_known_ = is_known_ || found == kAxes;
}

bool GraphArm::is_known() const {
  const std::lock_guard lock(mutex_);
  return is_known_;
}

void GraphArm::command(const Axes& q) {
  msgs::JointCommand message;
  message.mutable_header()->set_stamp(node_.clock().now());
  message.set_mode(msgs::JointCommand::POSITION);
  for (std::size_t i = 0; i < kAxes; ++i) {
    message.add_joint_name(joints_[i]);
    message.add_value(q[i]);
  }
  publisher_.publish(message);
}

Axes GraphArm::advance(double) {
  const std::lock_guard lock(mutex_);
  return actual_;
}

}  // namespace prehend::drivers::kuka_rsi
