#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "msgs/actions.pb.h"
#include "nodes/emergency_stop_listener/emergency_stop_listener.h"
#include "prehend/graph/node.h"
#include "prehend/simulation/arm_drive.h"

namespace prehend::nodes {

/// An arm, or a stage, be it simulated or real, that belongs to who asked last, known by a ticket.
/// May be asked from any thread.
class MovedArm {
 public:
  virtual ~MovedArm() = default;

  struct State {
    simulation::ArmDrive::Status status = simulation::ArmDrive::Status::kIdle;
    bool at_rest = true, contact = false;  // contact: it was stopped by it
    double time = 0, largest_error = 0;    // s, on the trajectory; rad or m
    robot::Positions desired, actual;
    std::string reason;  // why it ended short of the goal, where more is known than the status
  };

  /// Takes the arm over from whoever had it.
  virtual std::uint64_t take_arm() = 0;
  virtual bool holds_arm(std::uint64_t ticket) = 0;
  /// Brakes the arm, if it is still the ticket's.
  virtual void stop_arm(std::uint64_t ticket) = 0;
  /// Starts; stops where the wrist feels more than `contact_force` [N] if that is positive.
  /// @throws std::invalid_argument as simulation::check_trajectory(); the last one is forgotten
  /// then.
  virtual void follow(const simulation::TrajectoryRequest& request,
                      const std::vector<double>& tolerance, double contact_force) = 0;
  virtual State arm_state() = 0;
  /// Waits for the next slice, at most 100 ms of wall time.
  virtual void wait_for_slice() = 0;
};

/// The action /arm/follow and the service /arm/stop. Every goal has its own end; one whose client
/// cancels, dies or is preempted by a newer goal brakes the arm within its acceleration limits. A
/// newer trajectory begins where the arm then stands. An emergency stop brakes it, too, and goals
/// are refused until that is reset.
class ArmAction {
 public:
  /// `emergency` lives longer.
  ArmAction(graph::Node& node, MovedArm& arm, EmergencyStopListener& emergency);

 private:
  using Context = graph::ActionContext<msgs::FollowTrajectoryFeedback>;
  msgs::FollowTrajectoryResult follow(const msgs::FollowTrajectoryGoal& goal, Context& context);
  void brake(std::uint64_t ticket);

  graph::Node& node_;
  MovedArm& arm_;
  const EmergencyStopListener& emergency_;
  graph::Service stop_;
  graph::ActionServer follow_;
  EmergencyStopListener::Action emergency_stop_;
};

}  // namespace prehend::nodes
