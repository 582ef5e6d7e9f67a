#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "drivers/ros/driver/action_client.h"
#include "drivers/ros/driver/joint_listener.h"
#include "drivers/ros/driver/mapping.h"
#include "prehend/robot/gripper_model.h"

namespace prehend::drivers::ros_link {

/// A parallel gripper whose driver is ROS's, by its action control_msgs/GripperCommand and the
/// joint that it tells of. Openings are held to the model's here. How fast it moves is the
/// driver's, as the action does not say it. Any thread.
class RosGripper {
 public:
  struct State {
    bool is_known = false;  // the joint is heard of
    double opening = 0;     // m
    double velocity = 0;    // m/s
    double current = 0;     // A, of what effort its joint tells
    bool moves = false;     // a goal runs
    bool blocked = false;   // the last goal ended short of its opening, on something
  };
  enum class End { kRunning, kReached, kBlocked, kReplaced, kFailed };
  struct Motion {
    End end = End::kRunning;
    std::string reason;
  };

  /// `peer` lives longer.
  RosGripper(RosPeer& peer, const Mapping::Gripper& options, robot::GripperModel model,
             RosProblem tell);

  State state() const;
  /// Why it takes no motion now; "": it does.
  std::string obstacle() const;
  /// To `opening` [m], with at most `current` [A]; 0: the model's nominal. Takes the place of the
  /// motion before. @returns "" and the motion's ticket, or why not
  std::string move_to(double opening, double current, std::uint64_t& ticket);
  Motion motion(std::uint64_t ticket) const;
  void stop(const std::string& why);
  /// Several times a second: ends a motion of which nothing comes any more.
  void look();

 private:
  void end(std::uint64_t ticket, GoalEnd end, const recording::RosValue* result,
           const std::string& text);

  const Mapping::Gripper options_;
  const robot::GripperModel model_;
  const RosProblem tell_;
  mutable std::mutex mutex_;  // guards the next three
  std::uint64_t ticket_ = 0;
  Motion motion_{End::kReached, {}};
  bool stops_ = false;
  JointListener joints_;
  std::unique_ptr<RosActionClient> action_;
};

}  // namespace prehend::drivers::ros_link
