#include "nodes/simulation/robot_actions.h"

#include <algorithm>
#include <stdexcept>

#include "prehend/text/nearest_match.h"

namespace prehend::nodes {
namespace {

using simulation::RobotWorld;

constexpr int kHandSlicesPerFeedback = 5;  // 20 Hz

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

RobotActions::RobotActions(graph::Node& node, RobotRunner& robot)
    : node_(node), robot_(robot), arm_(node, robot) {
  stop_hand_ = node.serve<msgs::Empty, msgs::Acknowledge>("/hand/stop", [this](const msgs::Empty&) {
    robot_.take_hand();
    robot_.with_world([](RobotWorld& world) { world.stop_hand(); });
    return done();
  });
  hand_ = node.serve_action<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult>(
      "/hand/move", [this](const msgs::MoveHandGoal& goal, HandContext& context) {
        return move_hand(goal, context);
      });
}

// Joints that are not named stay where they are held.
simulation::HandCommand RobotActions::command_of(const msgs::MoveHandGoal& goal,
                                                 std::vector<int>& motors) const {
  simulation::HandCommand command;
  command.speed = goal.speed();
  command.until_contact = goal.until_contact();
  std::vector<std::string> names;
  std::vector<double> most;
  robot_.with_world([&](RobotWorld& world) {
    names = world.motor_names();
    command.position = world.hand().targets();
    command.effort = world.hand().most_efforts();
  });
  const auto refuse = [](const std::string& what) { throw std::invalid_argument(what); };
  if (goal.joint_name().empty()) refuse("the goal names no joint");
  if (goal.position_size() != goal.joint_name_size()) {
    refuse(fmt::format("{} positions for {} joints", goal.position_size(), goal.joint_name_size()));
  }
  if (goal.effort_size() != 0 && goal.effort_size() != goal.joint_name_size()) {
    refuse(fmt::format("{} efforts for {} joints", goal.effort_size(), goal.joint_name_size()));
  }
  for (int i = 0; i < goal.joint_name_size(); ++i) {
    // A hand's own names are its platform's without the prefix.
    const std::string& name = goal.joint_name(i);
    auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) found = std::find(names.begin(), names.end(), "hand_" + name);
    if (found == names.end()) {
      refuse(
          fmt::format("the hand has no motor '{}'{}", name, text::nearest_match_hint(name, names)));
    }
    const int motor = static_cast<int>(found - names.begin());
    if (std::find(motors.begin(), motors.end(), motor) != motors.end()) {
      refuse(fmt::format("joint '{}' is named twice", name));
    }
    motors.push_back(motor);
    command.position[motor] = goal.position(i);
    if (goal.effort_size() > 0) command.effort[motor] = goal.effort(i);
  }
  return command;
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
    const simulation::HandCommand command = command_of(goal, motors);
    robot_.with_world([&](RobotWorld& world) { world.move_hand(command); });
    ticket = robot_.take_hand();
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
    if (!robot_.holds_hand(ticket)) return finish("another command took the hand over");
    if (!moving) {
      result.set_reached(reached);
      result.set_blocked(blocked);
      return finish(reached ? "" : (goal.until_contact() ? "pressing" : "blocked"));
    }
    if (context.cancelled()) {
      if (!context.preempted()) robot_.with_world([](RobotWorld& world) { world.stop_hand(); });
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
