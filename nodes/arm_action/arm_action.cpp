#include "nodes/arm_action/arm_action.h"

#include <stdexcept>

namespace prehend::nodes {
namespace {

using simulation::ArmDrive;

constexpr int kArmSlicesPerFeedback = 5;  // 20 Hz

simulation::TrajectoryRequest request_of(const msgs::JointTrajectory& trajectory) {
  simulation::TrajectoryRequest request;
  request.joints.assign(trajectory.joint_name().begin(), trajectory.joint_name().end());
  for (const msgs::JointTrajectoryPoint& point : trajectory.points()) {
    request.points.push_back({point.time(),
                              {point.position().begin(), point.position().end()},
                              {point.velocity().begin(), point.velocity().end()},
                              {point.acceleration().begin(), point.acceleration().end()}});
  }
  return request;
}

void put_positions(const robot::Positions& values,
                   google::protobuf::RepeatedField<double>* message) {
  for (const double value : values) message->Add(value);
}

}  // namespace

ArmAction::ArmAction(graph::Node& node, MovedArm& arm, EmergencyStopListener& emergency)
    : node_(node), arm_(arm), emergency_(emergency) {
  stop_ = node.serve<msgs::Empty, msgs::Acknowledge>("/arm/stop", [this](const msgs::Empty&) {
    arm_.stop_arm(arm_.take_arm());
    msgs::Acknowledge answer;
    answer.set_success(true);
    return answer;
  });
  follow_ = node.serve_action<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                              msgs::FollowTrajectoryResult>(
      "/arm/follow", [this](const msgs::FollowTrajectoryGoal& goal, Context& context) {
        return follow(goal, context);
      });
  emergency_stop_ =
      emergency.on_stop([this](const std::string&) { arm_.stop_arm(arm_.take_arm()); });
}

// Until it stands, or is somebody else's.
void ArmAction::brake(std::uint64_t ticket) {
  arm_.stop_arm(ticket);
  while (!arm_.arm_state().at_rest && arm_.holds_arm(ticket) && node_.ok()) arm_.wait_for_slice();
}

msgs::FollowTrajectoryResult ArmAction::follow(const msgs::FollowTrajectoryGoal& goal,
                                               Context& context) {
  msgs::FollowTrajectoryResult result;
  const std::uint64_t ticket = arm_.take_arm();
  brake(ticket);
  if (!arm_.holds_arm(ticket)) {
    result.set_reason("a newer trajectory came");
    return result;
  }
  const auto finish = [&](const std::string& reason) {
    const MovedArm::State now = arm_.arm_state();
    put_positions(now.actual, result.mutable_position());
    result.set_largest_error(now.largest_error);
    result.set_reason(reason);
    return result;
  };
  if (const std::string why = emergency_.refusal(); !why.empty()) return finish(why);
  try {
    if (goal.stop_on_contact() && !(goal.contact_force() > 0)) {
      throw std::invalid_argument("contact_force must be positive");
    }
    arm_.follow(request_of(goal.trajectory()),
                {goal.path_tolerance().begin(), goal.path_tolerance().end()},
                goal.stop_on_contact() ? goal.contact_force() : 0.0);
  } catch (const std::invalid_argument& error) {
    return finish(error.what());
  }
  for (int slice = 0; node_.ok(); ++slice) {
    arm_.wait_for_slice();
    const MovedArm::State now = arm_.arm_state();
    if (const std::string why = emergency_.refusal(); !why.empty()) {
      brake(arm_.take_arm());  // also where it came before the motion had begun
      return finish(why);
    }
    if (!arm_.holds_arm(ticket)) {
      return finish(context.preempted() ? "a newer trajectory came; stopped"
                                        : "stopped before the goal");
    }
    if (context.cancelled()) {
      brake(ticket);
      return finish("cancelled; stopped before the goal");
    }
    if (now.status == ArmDrive::Status::kReached) {
      result.set_reached(true);
      return finish("");
    }
    if (now.status != ArmDrive::Status::kMoving && now.at_rest) {
      result.set_contact(now.contact);
      if (!now.reason.empty()) return finish(now.reason);
      return finish(now.contact ? "stopped by contact" : "stopped before the goal");
    }
    if (slice % kArmSlicesPerFeedback != 0) continue;
    msgs::FollowTrajectoryFeedback feedback;
    feedback.set_time(now.time);
    put_positions(now.desired, feedback.mutable_desired());
    put_positions(now.actual, feedback.mutable_actual());
    context.feedback(feedback);
  }
  return finish("the server ends");
}

}  // namespace prehend::nodes
