#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <string>

#include "drivers/ros/driver/action_client.h"
#include "drivers/ros/driver/joint_listener.h"
#include "drivers/ros/driver/mapping.h"
#include "nodes/arm_action/arm_action.h"

namespace prehend::drivers::ros_link {

/// An arm whose driver is ROS's, as /arm/follow moves it. Its goals are held to the platform's
/// limits of position and speed here, before they are sent. What was sent ends by itself when this
/// process dies: the controller of ROS has it. Any thread.
class RosArm : public nodes::MovedArm {
 public:
  /// `peer` lives longer.
  RosArm(RosPeer& peer, const Mapping::Arm& options, robot::KinematicChain chain, RosProblem tell);

  std::uint64_t take_arm() override;
  bool holds_arm(std::uint64_t ticket) override;
  void stop_arm(std::uint64_t ticket) override;
  void follow(const simulation::TrajectoryRequest& request, const std::vector<double>& tolerance,
              double contact_force) override;
  State arm_state() override;
  void wait_for_slice() override;

  /// What the wrist feels [N]: a motion that minds contact is stopped by it.
  void feel(double force);
  /// Several times a second: stops a motion of which no joint states come any more, or whose action
  /// does not end.
  void look();

  /// The arm's joints by the platform's names; empty when they are not heard of.
  std::vector<JointListener::Joint> joints() const;
  const robot::KinematicChain& chain() const { return chain_; }
  /// Why it cannot move now; "": it can.
  std::string obstacle() const;

 private:
  using Clock = std::chrono::steady_clock;
  using Status = simulation::ArmDrive::Status;

  std::string ros_name(const std::string& joint) const;
  std::optional<robot::Positions> positions() const;
  void end(std::uint64_t motion, GoalEnd end, const recording::RosValue* result,
           const std::string& text);
  void stop_locked(const std::string& why);
  double elapsed() const;  // s, of the motion

  const Mapping::Arm options_;
  const robot::KinematicChain chain_;
  const RosProblem tell_;
  mutable std::mutex mutex_;  // guards what follows up to `joints_`
  std::uint64_t ticket_ = 0, motion_ = 0;
  simulation::ArmTrajectory trajectory_;
  Clock::time_point began_{};
  Status status_ = Status::kIdle;
  bool runs_ = false, contact_ = false;
  double contact_force_ = 0, largest_error_ = 0;
  std::string reason_;
  JointListener joints_;
  std::unique_ptr<RosActionClient> action_;
};

}  // namespace prehend::drivers::ros_link
