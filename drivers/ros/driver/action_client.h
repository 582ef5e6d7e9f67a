#pragma once

#include <functional>
#include <memory>
#include <string>

#include "drivers/ros/transport/ros_peer.h"

namespace prehend::drivers::ros_link {

enum class GoalEnd { kSucceeded, kAborted, kCancelled, kRejected };
const char* to_string(GoalEnd end);

/// A client of an action of ROS: of ROS 1 by actionlib's five topics (wiki.ros.org/actionlib,
/// "Detailed Description"), of ROS 2 by three services and two topics (design.ros2.org, "Actions").
/// Services go as rmw_cyclonedds has them, and so only to servers that run with it: those of other
/// middlewares mark requests otherwise, and no two of them understand one another's.
///
/// One goal at a time: a newer one takes the place of the one before, of which nothing is told any
/// more. Any thread.
class RosActionClient {
 public:
  /// `result`: a message with the action's fields; null of a goal that was rejected, and `text`
  /// why, where the server says it. In one of the peer's threads.
  using Done =
      std::function<void(GoalEnd end, const recording::RosValue* result, const std::string& text)>;
  virtual ~RosActionClient() = default;
  /// Whether a server is connected now.
  virtual bool has_server() const = 0;
  /// @param goal the fields of the action's goal
  /// @throws recording::RosError for fields that it does not have
  virtual void send(const recording::RosValue& goal, Done done) = 0;
  /// Asks the server to stop; the goal's end is still told.
  virtual void cancel() = 0;
};

/// @param name "/arm_controller/follow_joint_trajectory"
/// @param type one of ros::action_types()
/// `peer` lives longer.
std::unique_ptr<RosActionClient> action_client(RosPeer& peer, const std::string& name,
                                               const std::string& type);

}  // namespace prehend::drivers::ros_link
