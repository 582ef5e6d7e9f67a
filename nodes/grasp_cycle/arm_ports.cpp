#include "nodes/grasp_cycle/arm_ports.h"

namespace prehend::nodes {

using control::MotionStatus;

control::JointPath from_message(const msgs::JointTrajectory& trajectory) {
  control::JointPath path;
  path.joints.assign(trajectory.joint_name().begin(), trajectory.joint_name().end());
  for (const msgs::JointTrajectoryPoint& point : trajectory.points()) {
    path.points.push_back({point.time(),
                           {point.position().begin(), point.position().end()},
                           {point.velocity().begin(), point.velocity().end()},
                           {point.acceleration().begin(), point.acceleration().end()}});
  }
  return path;
}

msgs::JointTrajectory to_message(const control::JointPath& path) {
  msgs::JointTrajectory trajectory;
  for (const std::string& name : path.joints) trajectory.add_joint_name(name);
  for (const control::JointPath::Point& point : path.points) {
    msgs::JointTrajectoryPoint& out = *trajectory.add_points();
    out.set_time(point.time);
    for (const double value : point.position) out.add_position(value);
    for (const double value : point.velocity) out.add_velocity(value);
    for (const double value : point.acceleration) out.add_acceleration(value);
  }
  return trajectory;
}

ArmActions::ArmActions(graph::Node& node) : goal_(node, "/arm/follow") {}

void ArmActions::follow(const control::JointPath& path, double contact_force) {
  msgs::FollowTrajectoryGoal goal;
  *goal.mutable_trajectory() = to_message(path);
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
                       double speed, bool until_contact) {
  msgs::MoveHandGoal goal;
  for (const std::string& name : joints) goal.add_joint_name(name);
  for (const double position : positions) goal.add_position(position);
  goal.set_speed(speed);
  goal.set_until_contact(until_contact);
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
