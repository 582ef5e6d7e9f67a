#include "nodes/simulation/robot_actions.h"

#include <stdexcept>

#include "prehend/simulation/hand_request.h"

namespace prehend::nodes {
namespace {

using simulation::ArmDrive;
using simulation::RobotWorld;

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

RobotActions::RobotActions(graph::Node& node, RobotRunner& robot) : node_(node), robot_(robot) {
  stop_arm_ = node.serve<msgs::Empty, msgs::Acknowledge>("/arm/stop", [this](const msgs::Empty&) {
    robot_.take_arm();
    robot_.with_world([](RobotWorld& world) { world.arm().stop(); });
    return done();
  });
  stop_hand_ = node.serve<msgs::Empty, msgs::Acknowledge>("/hand/stop", [this](const msgs::Empty&) {
    robot_.take_hand();
    robot_.with_world([](RobotWorld& world) { world.stop_hand(); });
    return done();
  });
  arm_ = node.serve_action<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                           msgs::FollowTrajectoryResult>(
      "/arm/follow", [this](const msgs::FollowTrajectoryGoal& goal, ArmContext& context) {
        return follow(goal, context);
      });
  hand_ = node.serve_action<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult>(
      "/hand/move", [this](const msgs::MoveHandGoal& goal, HandContext& context) {
        return move_hand(goal, context);
      });
}

// Until it stands, or is somebody else's.
void RobotActions::brake(std::uint64_t ticket) {
  robot_.stop_arm(ticket);
  const auto at_rest = [](RobotWorld& world) { return world.arm().at_rest(); };
  while (!robot_.with_world(at_rest) && robot_.holds_arm(ticket) && node_.ok()) {
    robot_.wait_for_slice();
  }
}

msgs::FollowTrajectoryResult RobotActions::follow(const msgs::FollowTrajectoryGoal& goal,
                                                  ArmContext& context) {
  msgs::FollowTrajectoryResult result;
  const std::uint64_t ticket = robot_.take_arm();
  brake(ticket);
  if (!robot_.holds_arm(ticket)) {
    result.set_reason("a newer trajectory came");
    return result;
  }
  const auto finish = [&](const std::string& reason) {
    robot_.with_world([&](RobotWorld& world) {
      put(world.arm().position(), result.mutable_position());
      result.set_largest_error(world.arm().largest_error());
    });
    result.set_reason(reason);
    return result;
  };
  try {
    if (goal.stop_on_contact() && !(goal.contact_force() > 0)) {
      throw std::invalid_argument("contact_force must be positive");
    }
    robot_.with_world([&](RobotWorld& world) {
      world.follow(request_of(goal.trajectory()),
                   {goal.path_tolerance().begin(), goal.path_tolerance().end()});
      if (goal.stop_on_contact()) world.stop_on_contact(goal.contact_force());
    });
  } catch (const std::invalid_argument& error) {
    robot_.with_world([](RobotWorld& world) { world.arm().forget(); });
    return finish(error.what());
  }
  struct Now {
    ArmDrive::Status status = ArmDrive::Status::kMoving;
    bool at_rest = false, contact = false;
    double time = 0;
    Eigen::VectorXd desired, actual;
    std::string reason;
  } now;
  for (int slice = 0; node_.ok(); ++slice) {
    robot_.wait_for_slice();
    robot_.with_world([&](RobotWorld& world) {
      const ArmDrive& arm = world.arm();
      now = {arm.status(),   arm.at_rest(), world.stopped_by_contact(), arm.time(), arm.desired(),
             arm.position(), arm.reason()};
    });
    if (!robot_.holds_arm(ticket)) {
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
      if (now.status == ArmDrive::Status::kOffPath) return finish(now.reason);
      return finish(now.contact ? "stopped by contact" : "stopped before the goal");
    }
    if (slice % kArmSlicesPerFeedback != 0) continue;
    msgs::FollowTrajectoryFeedback feedback;
    feedback.set_time(now.time);
    put(now.desired, feedback.mutable_desired());
    put(now.actual, feedback.mutable_actual());
    context.feedback(feedback);
  }
  return finish("the simulation ends");
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
    robot_.with_world([&](RobotWorld& world) {
      const simulation::NamedHandCommand named = check_hand_request(world, request_of(goal));
      motors = named.motors;
      world.move_hand(named.command);
    });
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
    if (slice % kArmSlicesPerFeedback != 0) continue;
    msgs::MoveHandFeedback feedback;
    put(q, feedback.mutable_position());
    context.feedback(feedback);
  }
  return finish("the simulation ends");
}

}  // namespace prehend::nodes
