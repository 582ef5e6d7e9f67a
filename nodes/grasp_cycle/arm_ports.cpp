#include "nodes/grasp_cycle/arm_ports.h"

#include "msgs/convert/cycle.h"

namespace prehend::nodes {

using control::MotionStatus;

ArmActions::ArmActions(graph::Node& node) : goal_(node, "/arm/follow") {}

void ArmActions::follow(const control::JointTrajectory& path, double contact_force) {
  msgs::FollowTrajectoryGoal goal;
  *goal.mutable_trajectory() = convert::to_message(path);
  goal.set_stop_on_contact(contact_force > 0);
  goal.set_contact_force(contact_force);
  problem_.clear();
  goal_.send(goal);
}

MotionStatus ArmActions::motion() {
  const auto outcome = goal_.end();
  if (!outcome) return MotionStatus::kMoving;
  const bool ok = outcome->ok();
  if (ok && (*outcome)->reached()) return MotionStatus::kReached;
  problem_ = "/arm/follow: " + (ok ? (*outcome)->reason() : outcome->error());
  return ok && (*outcome)->contact() ? MotionStatus::kContact : MotionStatus::kFailed;
}

HandActions::HandActions(graph::Node& node) : node_(node), goal_(node, "/hand/move") {}

void HandActions::move(const std::vector<std::string>& joints, const std::vector<double>& positions,
                       double speed, bool until_contact, const std::vector<double>& effort) {
  msgs::MoveHandGoal goal;
  for (const std::string& name : joints) goal.add_joint_name(name);
  for (const double position : positions) goal.add_position(position);
  goal.set_speed(speed);
  goal.set_until_contact(until_contact);
  for (const double most : effort) goal.add_effort(most);
  goal.set_stamp(node_.clock().now());
  problem_.clear();
  positions_.clear();
  goal_.send(goal);
}

MotionStatus HandActions::motion() {
  const auto outcome = goal_.end();
  if (!outcome) return MotionStatus::kMoving;
  const bool ok = outcome->ok();
  if (ok) positions_.assign((*outcome)->position().begin(), (*outcome)->position().end());
  if (ok && (*outcome)->reached()) return MotionStatus::kReached;
  problem_ = "/hand/move: " + (ok ? (*outcome)->reason() : outcome->error());
  return ok && (*outcome)->blocked() ? MotionStatus::kContact : MotionStatus::kFailed;
}

}  // namespace prehend::nodes
