#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "msgs/ros/definitions.h"

namespace prehend::drivers::ros_link {

/// Quality of service, in ROS 2's terms. ROS 1 has `is_latched` of publishers and the depth alone.
struct RosQos {
  bool is_reliable = true;
  bool is_latched = false;  // transient local, depth 1 or more
  std::size_t depth = 10;   // keep last
};

/// What a channel is to a peer. ROS 1 has topics alone; the others are halves of ROS 2's services
/// (design.ros2.org, "Topic and Service name mapping to DDS").
enum class RosChannel { kTopic, kRequest, kReply };

/// Publishes encoded messages. Destroying it withdraws the topic. Any thread.
class RosPublisher {
 public:
  virtual ~RosPublisher() = default;
  virtual void publish(std::string bytes) = 0;
  /// Readers of ROS that are connected now.
  virtual std::size_t readers() const = 0;
};

/// Destroying it ends the subscription; no callback runs after that.
class RosSubscription {
 public:
  virtual ~RosSubscription() = default;
  /// Writers of ROS that are connected now.
  virtual std::size_t writers() const = 0;
};

/// The side of a bridge that is ROS. All functions may be called from any thread.
class RosPeer {
 public:
  virtual ~RosPeer() = default;
  virtual ros::Version version() const = 0;
  /// @param name as ROS has it: "/camera/points". @param type "sensor_msgs/PointCloud2", one that
  /// ros::has_definition() knows.
  /// @throws std::runtime_error in words when ROS refuses.
  virtual std::unique_ptr<RosPublisher> advertise(const std::string& name, const std::string& type,
                                                  const RosQos& qos,
                                                  RosChannel channel = RosChannel::kTopic) = 0;
  /// `take` gets the bytes of each message, in one of the peer's threads; it does not throw.
  virtual std::unique_ptr<RosSubscription> subscribe(const std::string& name,
                                                     const std::string& type, const RosQos& qos,
                                                     std::function<void(std::string_view)> take,
                                                     RosChannel channel = RosChannel::kTopic) = 0;
};

/// Told of what does not fit together: a type or quality of service that a peer has otherwise, a
/// master that is gone. In one of the peer's threads; each once.
using RosProblem = std::function<void(const std::string&)>;

}  // namespace prehend::drivers::ros_link
