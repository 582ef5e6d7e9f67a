#include "nodes/simulation/robot_actions.h"

#include <stdexcept>

#include "msgs/convert/gripper.h"
#include "prehend/simulation/hand_request.h"

namespace prehend::nodes {
namespace {

using simulation::RobotWorld;

constexpr int kHandSlicesPerFeedback = 5;  // 20 Hz

simulation::HandRequest request_of(const msgs::MoveHandGoal& goal) {
  return {{goal.joint_name().begin(), goal.joint_name().end()},
          {goal.position().begin(), goal.position().end()},
          goal.speed(),
          goal.until_contact(),
          {goal.effort().begin(), goal.effort().end()}};
}

template <class Values, class Message>
void put(const Values& values, Message* message) {
  for (Eigen::Index i = 0; i < values.size(); ++i) message->Add(values[i]);
}

msgs::Acknowledge done() {
  msgs::Acknowledge answer;
  answer.set_success(true);
  return answer;
}

}  // namespace

RobotActions::RobotActions(graph::Node& node, RobotRunner& robot, EmergencyStopListener& of_arm,
                           EmergencyStopListener& of_hand)
    : node_(node), robot_(robot), emergency_(of_hand), arm_(node, robot, of_arm) {
  stop_hand_ = node.serve<msgs::Empty, msgs::Acknowledge>("/hand/stop", [this](const msgs::Empty&) {
    robot_.stop_hand("stopped by /hand/stop");
    return done();
  });
  command_ = node.subscribe<msgs::JointCommand>(
      "/hand/command", graph::QoS::queue(20),
      [this](const graph::Received<msgs::JointCommand>& message) { command(*message); });
  hand_ = node.serve_action<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult>(
      "/hand/move", [this](const msgs::MoveHandGoal& goal, HandContext& context) {
        return move_hand(goal, context);
      });
  emergency_stop_ = of_hand.on_stop([this](const std::string& why) { robot_.stop_hand(why); });
}

void RobotActions::command(const msgs::JointCommand& command) {
  // A stream goes on: what is wrong with it is said when it begins.
  const auto say = [this](const std::string& words) {
    if (words != said_) node_.log_warning("/hand/command {}", words);
    said_ = words;
  };
  const auto mode = convert::from_message(command.mode());
  if (!mode) return say("refused: unknown mode of a joint command");
  const std::string why = emergency_.refusal();
  if (!why.empty() && *mode != robot::JointMode::kStop) return say("refused: " + why);
  try {
    const simulation::JointsRequest request{
        *mode,
        {command.joint_name().begin(), command.joint_name().end()},
        {command.value().begin(), command.value().end()}};
    if (!robot_.command_hand(request, command.header().stamp())) {
      return say("ignored: it is stamped before the goal of /hand/move that came");
    }
    said_.clear();
    // It came meanwhile.
    if (const std::string now = emergency_.refusal(); !now.empty()) robot_.stop_hand(now);
  } catch (const std::invalid_argument& error) {
    say("refused: " + std::string(error.what()));
  }
}

msgs::MoveHandResult RobotActions::move_hand(const msgs::MoveHandGoal& goal, HandContext& context) {
  msgs::MoveHandResult result;
  std::vector<int> motors;
  const auto finish = [&](const std::string& reason) {
    const Eigen::VectorXd q =
        robot_.with_world([](RobotWorld& world) { return world.hand_positions(); });
    for (const int motor : motors) result.add_position(q[motor]);
    result.set_reason(reason);
    return result;
  };
  std::uint64_t ticket = 0;
  try {
    const simulation::NamedHandCommand named = robot_.with_world(
        [&](RobotWorld& world) { return check_hand_request(world, request_of(goal)); });
    motors = named.motors;
    if (const std::string why = emergency_.refusal(); !why.empty()) return finish(why);
    ticket = robot_.move_hand(named.command, goal.stamp());
    // It came meanwhile.
    if (const std::string why = emergency_.refusal(); !why.empty()) robot_.stop_hand(why);
  } catch (const std::invalid_argument& error) {
    return finish(error.what());
  }
  for (int slice = 0; node_.ok(); ++slice) {
    robot_.wait_for_slice();
    bool moving = true, blocked = false, reached = false;
    Eigen::VectorXd q;
    robot_.with_world([&](RobotWorld& world) {
      moving = world.hand().moving();
      blocked = world.hand().blocked();
      reached = world.hand().reached();
      q = world.hand_positions();
    });
    if (const std::string loss = robot_.loss_of_hand(ticket); !loss.empty()) return finish(loss);
    if (!moving) {
      result.set_reached(reached);
      result.set_blocked(blocked);
      return finish(reached ? "" : (goal.until_contact() ? "pressing" : "blocked"));
    }
    if (context.cancelled()) {
      if (!context.preempted()) robot_.stop_hand("cancelled");
      return finish("cancelled");
    }
    if (slice % kHandSlicesPerFeedback != 0) continue;
    msgs::MoveHandFeedback feedback;
    put(q, feedback.mutable_position());
    context.feedback(feedback);
  }
  return finish("the simulation ends");
}

}  // namespace prehend::nodes
