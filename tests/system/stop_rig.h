#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "msgs/actions.pb.h"
#include "msgs/joints.pb.h"
#include "msgs/safety.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "tests/system/launched.h"

namespace prehend::testing {

/// What an emulated device does by itself, by a parameter of its emulator.
struct DeviceFault {
  std::string emulator, parameter, value;
  std::string mended;        // its value then; "": it mends itself
  std::string acknowledged;  // service to be called then, or none
  std::string words;         // of the driver
  std::size_t other = 0;     // of StopRig::reasons(): what of the robot moves on without a stop
};

/// A robot that is launched with the emergency stop beside it.
struct StoppedRobot {
  std::string name, launch_file;
  std::vector<std::string> arguments;  // PORT: a free one; LINES: names in a folder of its own
  std::vector<std::string> required;   // of the emergency stop; one that may be killed comes last
  std::string world_joints;            // topic: where the world's arm is
  // What moves arm and hand in the world, where emulated devices do; "": its own motors.
  std::string arm_set_points, hand_set_points;
  bool has_gripper = false;    // moved by /gripper/move
  std::string hand_joint;      // moved by /hand/move
  double least = 0, most = 0;  // m or rad, between which it is moved
  double speed = 0.2;          // share of the greatest, of /hand/move
  double way = 0.3;            // m or rad, of the arm's first joint
  DeviceFault fault;
  friend void PrintTo(const StoppedRobot& robot, std::ostream* out) { *out << robot.name; }
};

/// All emulators that there are, and what is simulated beside each: stage and PG70, a KUKA's arm
/// over RSI and a simulated gripper, simulated arms with an SDH-2 and with both BarrettHands.
std::vector<StoppedRobot> stopped_robots();

/// A robot of which arm and hand can be moved and stopped, and are watched in the world, whatever
/// their drivers say.
class StopRig {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using ArmResult = graph::Outcome<msgs::FollowTrajectoryResult>;

  explicit StopRig(const StoppedRobot& robot);
  ~StopRig();

  /// Waits until arm and hand are known and stand. "", or what is missing.
  std::string wait_until_ready();
  /// Begins to move arm and hand, to and fro by turns, and waits until both do. "" or what does
  /// not.
  std::string move();
  /// Why arm and hand refuse to move, or ended: their reasons, in this order.
  std::vector<std::string> reasons();
  /// Sends goals like move() and takes their ends at once.
  std::vector<std::string> refusals();
  msgs::Acknowledge stop(const std::string& reason);
  msgs::Acknowledge reset();
  bool is_stopped() const;
  std::string reason() const;
  /// SIGKILL to the process of a launched node, or the emergency stop's.
  bool kill(const std::string& node);
  void start_emergency_stop();
  /// When it told that it stopped for the last time; nothing while it is not stopped.
  std::optional<Time> told_stopped() const;

  /// How something moved.
  struct Track {
    double speed = 0;             // largest of its joints' at `from`
    std::optional<Time> slower;   // the last time that it was as fast as that, by 2 %
    std::optional<Time> stands;   // the first time from which on nothing of it moved
    std::optional<Time> command;  // the last set point that differs from the one before, if any
    bool stood = false;           // at the end
  };
  /// Of what was seen since `from`.
  Track arm_since(Time from) const;
  Track hand_since(Time from) const;
  /// Waits until both stand, since `from`, for `patience` at most.
  bool wait_until_stands(Time from, std::chrono::seconds patience) const;
  std::string output() const { return launched_.output(); }
  const std::string& registry() const { return registry_; }

 private:
  struct Sample {
    Time time;
    double speed = 0;
  };
  void take(const msgs::JointState& state);
  void keep_positions(const msgs::JointState& state);
  msgs::FollowTrajectoryGoal arm_goal();
  Track track(const std::vector<Sample>& samples, const std::vector<Time>& commands,
              Time from) const;
  std::vector<std::string> arguments_of(const StoppedRobot& robot) const;
  graph::NodeOptions options() const;
  void watch(const std::string& topic, std::vector<Time>& changes, std::string& last);

  const StoppedRobot robot_;
  ScratchFolder scratch_;
  std::string registry_;
  Launched launched_;
  std::unique_ptr<Launched> emergency_;
  graph::Node node_;

  mutable std::mutex mutex_;  // guards what follows
  std::vector<Sample> arm_, hand_;
  std::vector<Time> arm_commands_, hand_commands_;
  std::string arm_command_, hand_command_;
  std::vector<std::string> joints_;         // of the arm
  std::map<std::string, double> position_;  // of all, as the drivers say
  msgs::EmergencyStop state_;
  std::optional<Time> told_;
  double hand_position_ = 0;  // m or rad, in the world
  bool goes_ = false;         // fro, of the arm

  graph::ActionClient<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                      msgs::FollowTrajectoryResult>
      follow_;
  graph::ActionClient<msgs::MoveGripperGoal, msgs::MoveGripperFeedback, msgs::MoveGripperResult>
      move_gripper_;
  graph::ActionClient<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult> move_hand_;
  graph::GoalHandle<msgs::FollowTrajectoryResult> arm_goal_;
  graph::GoalHandle<msgs::MoveGripperResult> gripper_goal_;
  graph::GoalHandle<msgs::MoveHandResult> hand_goal_;
  graph::ServiceClient<msgs::EmergencyStopRequest, msgs::Acknowledge> stop_;
  graph::ServiceClient<msgs::Empty, msgs::Acknowledge> reset_;
  std::vector<graph::Subscription> subscriptions_;
};

}  // namespace prehend::testing
