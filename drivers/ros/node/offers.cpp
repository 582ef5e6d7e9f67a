#include "drivers/ros/node/offers.h"

#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "msgs/convert/gripper.h"

namespace prehend::drivers::ros_link {
namespace {

constexpr double kStatePeriod = 0.02;  // s
constexpr auto kTick = std::chrono::milliseconds(10);
constexpr int kTicksOfFeedback = 5;  // 20 Hz

std::vector<std::string> names_of(const robot::KinematicChain& chain) {
  std::vector<std::string> names;
  for (const robot::ChainJoint& joint : chain.joints()) names.push_back(joint.name);
  return names;
}

}  // namespace

ArmOffer::ArmOffer(graph::Node& node, RosArm& arm, nodes::EmergencyStopListener& emergency,
                   const std::string& other_joints)
    : arm_(arm),
      joints_(node, names_of(arm.chain()), other_joints,
              node.advertise<msgs::JointState>("/joint_states", graph::QoS::queue(100))),
      wrench_(node.subscribe<msgs::Wrench>("/wrench", graph::QoS::latest(),
                                           [&arm](const graph::Received<msgs::Wrench>& message) {
                                             const auto& force = message->wrench().force();
                                             arm.feel(std::hypot(force.x(), force.y(), force.z()));
                                           })),
      action_(node, arm, emergency),
      timer_(kStatePeriod, [this] { tell(); }) {}

void ArmOffer::tell() {
  arm_.look();
  std::vector<double> position, velocity, effort;
  for (const JointListener::Joint& joint : arm_.joints()) {
    position.push_back(joint.position);
    velocity.push_back(joint.velocity);
    effort.push_back(joint.effort);
  }
  if (!position.empty()) joints_.tell(position, velocity, effort);
}

GripperOffer::GripperOffer(graph::Node& node, RosGripper& gripper,
                           nodes::EmergencyStopListener& emergency, const std::string& file)
    : node_(node),
      gripper_(gripper),
      emergency_(emergency),
      model_(node.advertise<msgs::GripperDescription>("/gripper/model", graph::QoS::latched(1))),
      states_(node.advertise<msgs::GripperState>("/gripper/state", graph::QoS::queue(100))),
      stop_(node.serve<msgs::Empty, msgs::Acknowledge>("/gripper/stop",
                                                       [this](const msgs::Empty&) {
                                                         gripper_.stop("stopped by /gripper/stop");
                                                         msgs::Acknowledge answer;
                                                         answer.set_success(true);
                                                         return answer;
                                                       })),
      commands_(node.subscribe<msgs::GripperCommand>(
          "/gripper/command", graph::QoS::queue(20),
          [this](const graph::Received<msgs::GripperCommand>& message) { command(*message); })),
      move_(node.serve_action<msgs::MoveGripperGoal, msgs::MoveGripperFeedback,
                              msgs::MoveGripperResult>(
          "/gripper/move", [this](const msgs::MoveGripperGoal& goal,
                                  Context& context) { return move(goal, context); })),
      emergency_stop_(emergency.on_stop([this](const std::string& why) { gripper_.stop(why); })),
      timer_(kStatePeriod, [this] { tell(); }) {
  model_.publish(convert::describe_gripper(file));
}

void GripperOffer::tell() {
  gripper_.look();
  const RosGripper::State now = gripper_.state();
  if (!now.is_known) return;
  msgs::GripperState message;
  message.mutable_header()->set_stamp(node_.clock().now());
  message.mutable_header()->set_frame_id("gripper");
  message.set_opening(now.opening);
  message.set_velocity(now.velocity);
  message.set_current(now.current);
  message.set_referenced(true);
  message.set_moving(now.moves);
  message.set_blocked(now.blocked);
  states_.publish(std::move(message));
}

void GripperOffer::command(const msgs::GripperCommand& command) {
  const std::int64_t stamp = command.header().stamp();
  if (stamp != 0 && stamp <= action_stamp_) return;  // meant to come before the goal
  std::string refusal;
  if (command.mode() == msgs::GripperCommand::STOP) {
    gripper_.stop("stopped by /gripper/command");
  } else if (command.mode() == msgs::GripperCommand::POSITION) {
    std::uint64_t ticket = 0;
    refusal = emergency_.refusal();
    if (refusal.empty())
      refusal = gripper_.move_to(command.value(), command.current_limit(), ticket);
  } else {
    refusal = msgs::GripperCommand::Mode_Name(command.mode()) +
              ": the action of ROS has no such command. Send POSITION";
  }
  if (!refusal.empty()) node_.log_warning("/gripper/command refused: {}", refusal);
}

msgs::MoveGripperResult GripperOffer::move(const msgs::MoveGripperGoal& goal, Context& context) {
  msgs::MoveGripperResult result;
  action_stamp_ = goal.stamp();
  std::uint64_t ticket = 0;
  std::string refusal = emergency_.refusal();
  if (refusal.empty() && !(goal.speed() > 0)) refusal = "speed must be positive";
  if (refusal.empty()) refusal = gripper_.move_to(goal.opening(), goal.current_limit(), ticket);
  result.set_reason(refusal);
  bool stops = false;
  for (int tick = 0; refusal.empty() && node_.ok(); ++tick) {
    std::this_thread::sleep_for(kTick);
    const RosGripper::Motion motion = gripper_.motion(ticket);
    result.set_reached(motion.end == RosGripper::End::kReached);
    result.set_blocked(motion.end == RosGripper::End::kBlocked);
    result.set_reason(motion.reason);
    if (motion.end != RosGripper::End::kRunning) break;
    if (context.cancelled() && context.preempted()) break;
    if (context.cancelled() && !std::exchange(stops, true)) gripper_.stop("cancelled");
    if (tick % kTicksOfFeedback != 0) continue;
    msgs::MoveGripperFeedback feedback;
    feedback.set_opening(gripper_.state().opening);
    context.feedback(feedback);
  }
  result.set_opening(gripper_.state().opening);
  return result;
}

}  // namespace prehend::drivers::ros_link
