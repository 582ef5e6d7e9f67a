#pragma once

#include <functional>
#include <memory>
#include <string>

#include "drivers/ros/transport/ros_peer.h"

namespace prehend::drivers::ros_link {

/// A server of an action of ROS; see RosActionClient for how it goes over the wire. One goal at a
/// time: a new one is rejected while another runs. Any thread.
class RosActionServer {
 public:
  struct Handler {
    /// A goal came. "": it is taken; else why it is not. Does not wait.
    std::function<std::string(const recording::RosValue& goal)> begin;
    /// Its client wants it to end. Does not wait.
    std::function<void()> cancel;
  };
  virtual ~RosActionServer() = default;
  /// @param feedback the fields of the action's feedback
  virtual void feedback(const recording::RosValue& feedback) = 0;
  /// The goal has ended. @param text why, in words, for ROS 1, which has a place for it
  virtual void finish(bool success, bool cancelled, const recording::RosValue& result,
                      const std::string& text) = 0;
};

/// `peer` lives longer. @throws as RosPeer's functions
std::unique_ptr<RosActionServer> serve_action(RosPeer& peer, const std::string& name,
                                              const std::string& type,
                                              RosActionServer::Handler handler);

}  // namespace prehend::drivers::ros_link
