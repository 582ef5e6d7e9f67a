#include "drivers/ros/driver/joint_listener.h"

#include <cmath>
#include <utility>

#include "msgs/joints.pb.h"
#include "msgs/ros/from_ros.h"

namespace prehend::drivers::ros_link {

JointListener::JointListener(RosPeer& peer, const std::string& topic, RosProblem tell)
    : version_(peer.version()),
      topic_(topic),
      tell_(std::move(tell)),
      // Best effort is compatible with every publisher.
      subscription_(peer.subscribe(topic, "sensor_msgs/JointState",
                                   {.is_reliable = version_ == ros::Version::kRos1, .depth = 20},
                                   [this](std::string_view bytes) { take(bytes); })) {}

std::optional<JointListener::Joint> JointListener::joint(const std::string& name,
                                                         double age) const {
  const std::lock_guard lock(mutex_);
  const auto found = heard_.find(name);
  if (found == heard_.end()) return std::nullopt;
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - found->second.time;
  if (since.count() > age) return std::nullopt;
  return found->second.joint;
}

void JointListener::take(std::string_view bytes) {
  try {
    const auto message = ros::from_ros(
        "sensor_msgs/JointState",
        ros::type_of("sensor_msgs/JointState", version_).read(bytes, ros::encoding_of(version_)));
    const auto& joints = static_cast<const msgs::JointState&>(*message);
    const auto now = std::chrono::steady_clock::now();
    const std::lock_guard lock(mutex_);
    for (int i = 0; i < joints.name_size() && i < joints.position_size(); ++i) {
      if (!std::isfinite(joints.position(i))) continue;  // not known yet, as drivers say it
      const auto at = [i](const auto& values) { return i < values.size() ? values[i] : 0.0; };
      heard_[joints.name(i)] = {{joints.position(i), at(joints.velocity()), at(joints.effort())},
                                now};
    }
  } catch (const std::exception& error) {
    {
      const std::lock_guard lock(mutex_);
      if (std::exchange(told_, true)) return;
    }
    tell_(topic_ + ": " + error.what());
  }
}

}  // namespace prehend::drivers::ros_link
