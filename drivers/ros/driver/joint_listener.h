#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "drivers/ros/transport/ros_peer.h"

namespace prehend::drivers::ros_link {

/// The newest of each joint that a sensor_msgs/JointState topic tells. Several publishers may share
/// it, each with joints of its own. Any thread.
class JointListener {
 public:
  struct Joint {
    double position = 0, velocity = 0, effort = 0;  // rad, rad/s, N m; m, m/s, N
  };
  /// `peer` lives longer.
  JointListener(RosPeer& peer, const std::string& topic, RosProblem tell);

  /// Nothing when it was not heard of within `age` [s].
  std::optional<Joint> joint(const std::string& name, double age) const;

 private:
  using Time = std::chrono::steady_clock::time_point;
  void take(std::string_view bytes);

  struct Heard {
    Joint joint;
    Time time{};
  };
  const ros::Version version_;
  const std::string topic_;
  const RosProblem tell_;
  mutable std::mutex mutex_;  // guards the next two
  std::map<std::string, Heard> heard_;
  bool told_ = false;
  std::unique_ptr<RosSubscription> subscription_;
};

}  // namespace prehend::drivers::ros_link
