#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "drivers/ros/driver/action_server.h"
#include "msgs/actions.pb.h"
#include "msgs/grasp.pb.h"
#include "prehend/graph/introspection.h"
#include "prehend/graph/node.h"

namespace prehend::drivers::ros_link {

/// The action prehend_msgs/Pick of ROS: a cycle of the node grasp_cycle on the newest plans, with
/// an object and a grasp where the goal names them (-1: the best). Cancelling stops the cycle.
class PickOffer {
 public:
  /// `node` and `peer` live longer. @param cycle name of the node that grasps
  PickOffer(graph::Node& node, RosPeer& peer, const std::string& name, const std::string& cycle);
  ~PickOffer();

 private:
  std::string begin(const recording::RosValue& goal);
  void cancel();
  void take_state(const msgs::CycleState& state);
  void take_result(const msgs::CycleResult& result);

  graph::Node& node_;
  const std::string cycle_;
  graph::ServiceClient<msgs::Empty, msgs::Acknowledge> start_, stop_;
  std::mutex mutex_;  // guards the next two
  bool runs_ = false, cancelled_ = false;
  std::unique_ptr<RosActionServer> server_;
  graph::Subscription states_, results_;
};

}  // namespace prehend::drivers::ros_link
