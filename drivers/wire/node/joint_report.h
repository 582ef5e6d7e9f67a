#pragma once

#include <algorithm>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/wire/time/time.h"
#include "msgs/joints.pb.h"
#include "prehend/graph/node.h"

namespace prehend::drivers {

/// /joint_states by a driver of some of the robot's joints: its own, and with them what another
/// topic tells of the others, so that whoever listens hears of all joints at once. Others of which
/// nothing was heard for 0.25 s are left out.
class JointReport {
 public:
  /// `names`: the driver's own joints. `other`: the other topic; empty: there is none.
  JointReport(graph::Node& node, std::vector<std::string> names, const std::string& other,
              graph::Publisher<msgs::JointState> publisher)
      : node_(node), names_(std::move(names)), topic_(other), publisher_(std::move(publisher)) {
    if (other.empty()) return;
    others_ = node.subscribe<msgs::JointState>(
        other, graph::QoS::latest(), [this](const graph::Received<msgs::JointState>& message) {
          const std::lock_guard lock(mutex_);
          other_ = *message;
          other_time_ = steady_now();
        });
  }

  /// In the order of the names, rad, rad/s and N m; without efforts: 0. For one thread.
  void tell(std::span<const double> positions, std::span<const double> velocities,
            std::span<const double> efforts = {}) {
    msgs::JointState message;
    message.mutable_header()->set_stamp(node_.clock().now());
    for (std::size_t i = 0; i < names_.size(); ++i) {
      message.add_name(names_[i]);
      message.add_position(positions[i]);
      message.add_velocity(velocities[i]);
      message.add_effort(efforts.empty() ? 0 : efforts[i]);
    }
    add_others(message);
    publisher_.publish(message);
  }
  /// That nothing comes of the others; "" when all is well. Any thread.
  std::string problem() const {
    const std::lock_guard lock(mutex_);
    if (topic_.empty() || is_fresh()) return {};
    return "nothing comes on " + topic_ + ", so /joint_states has this device's joints alone";
  }

 private:
  bool is_fresh() const {
    constexpr double kOtherAge = 0.25;  // s of real time, as of the cycle's stale_time
    return other_ && steady_now() - other_time_ <= to_time(kOtherAge);
  }
  void add_others(msgs::JointState& message) {
    const std::lock_guard lock(mutex_);
    if (!is_fresh()) return;
    const auto at = [](const auto& values, int i) { return i < values.size() ? values[i] : 0.0; };
    for (int i = 0; i < std::min(other_->name_size(), other_->position_size()); ++i) {
      if (std::find(names_.begin(), names_.end(), other_->name(i)) != names_.end()) continue;
      message.add_name(other_->name(i));
      message.add_position(other_->position(i));
      message.add_velocity(at(other_->velocity(), i));
      message.add_effort(at(other_->effort(), i));
    }
  }

  graph::Node& node_;
  const std::vector<std::string> names_;
  const std::string topic_;
  graph::Publisher<msgs::JointState> publisher_;
  mutable std::mutex mutex_;  // guards what follows
  std::optional<msgs::JointState> other_;
  Time other_time_{};
  graph::Subscription others_;
};

}  // namespace prehend::drivers
