#pragma once

#include "drivers/pg70/driver/device.h"
#include "msgs/actions.pb.h"
#include "msgs/sensors.pb.h"
#include "nodes/emergency_stop_listener/emergency_stop_listener.h"
#include "prehend/graph/node.h"

namespace prehend::drivers::pg70 {

/// What the simulated gripper offers, by the real one: topic /gripper/command, action
/// /gripper/move, services /gripper/stop, /gripper/fast_stop and /gripper/acknowledge; and
/// /gripper/reference besides. An emergency stop is CMD STOP: the module brakes and holds its jaws
/// where they are, so that what they grip stays gripped; its motor is not switched off.
class GripperOffers {
 public:
  GripperOffers(graph::Node& node, Device& device, nodes::EmergencyStopListener& emergency);

 private:
  using Context = graph::ActionContext<msgs::MoveGripperFeedback>;
  msgs::MoveGripperResult move(const msgs::MoveGripperGoal& goal, Context& context);
  void command(const msgs::GripperCommand& command);
  msgs::Acknowledge acknowledge();
  msgs::Acknowledge stop(bool is_fast);
  std::string wait_until_stopped();

  graph::Node& node_;
  Device& device_;
  nodes::EmergencyStopListener& emergency_;
  std::atomic<std::int64_t> action_stamp_ = 0;  // ns, of the last goal
  graph::Service stop_, fast_stop_, acknowledge_, reference_;
  graph::Subscription command_;
  graph::ActionServer move_;
  nodes::EmergencyStopListener::Action emergency_stop_;
};

/// /gripper/state. `stamp` [ns].
msgs::GripperState state_message(const Reading& reading, std::int64_t stamp);

}  // namespace prehend::drivers::pg70
