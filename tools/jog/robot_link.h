#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "msgs/actions.pb.h"
#include "msgs/joints.pb.h"
#include "msgs/safety.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/robot/platform.h"
#include "tools/emergency_stop.h"

namespace prehend::tools {

/// A platform's arm and hand in a running graph, simulated or real, for who moves them by hand.
/// Ages are of the wall clock since a message came: of a paused simulation nothing comes.
class RobotLink {
 public:
  /// Joins the graph. `name` of the command: "jog". @throws std::runtime_error when no registry
  /// answers.
  RobotLink(const std::string& name, const std::string& registry, const robot::Platform& platform);
  ~RobotLink();

  bool has_gripper() const { return has_gripper_; }
  const robot::Platform& platform() const { return platform_; }

  struct Joints {
    robot::Positions arm, arm_velocity;       // of the chain; empty: never told
    std::vector<double> hand, hand_velocity;  // motors, or the opening; empty: never told
    std::vector<double> hand_effort;          // N m or N; empty: not told
    double arm_age = 1e9, hand_age = 1e9;     // s
    bool gripper_blocked = false;
  };
  Joints joints() const;
  enum class Needed { kArm, kHand, kBoth };
  /// The next one. @throws std::runtime_error naming what did not come within `patience` [s], or
  /// "interrupted".
  Joints wait_for_joints(double patience, Needed needed);
  /// Positions of all of the hand's joints; as its first preshape where it does not tell.
  Eigen::VectorXd hand_positions(const Joints& joints) const;

  struct Pad {
    std::string name;
    double force = 0;  // N, sum
    double age = 0;    // s
  };
  std::vector<Pad> pads() const;

  /// Why nothing may move: of the emergency stop; empty: it may.
  std::string forbidden() const;
  /// Lines since the last call: warnings and errors of nodes, this one's among them.
  std::vector<std::string> news();

  bool arm_takes_set_points() const { return arm_commands_.subscriber_count() > 0; }
  void command_arm(const robot::Positions& positions);
  void stop_arm();
  /// `motor` of the platform's hand; of a gripper the opening. rad/s or m/s.
  void command_hand(int motor, double speed);
  void stop_hand();
  /// The emergency stop; what was done, in words. Waits for at most a second.
  std::string emergency_stop(const std::string& reason);

  using Follow = graph::ActionClient<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                                     msgs::FollowTrajectoryResult>;
  using MoveHand =
      graph::ActionClient<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult>;
  using MoveGripper = graph::ActionClient<msgs::MoveGripperGoal, msgs::MoveGripperFeedback,
                                          msgs::MoveGripperResult>;
  Follow& follow() { return follow_; }
  /// Follows positions `period` [s] apart that begin where the arm stands; end_run() brakes it.
  void run_arm(const std::vector<robot::Positions>& positions, double period);
  void end_run();
  bool arm_runs() const { return run_ && !run_.done(); }
  bool arm_takes_runs() const { return follow_.wait_for_server(std::chrono::seconds(0)); }

  /// A motion of the hand as a whole: to `positions` of its motors (of a gripper: half of the
  /// opening), where it closes until it presses.
  struct HandGoal {
    Eigen::VectorXd positions;  // rad or m
    double speed = 0.3;         // share
    bool until_contact = false;
    std::vector<double> efforts;  // N m or N; empty: the hand's own
    double current = 0;           // A, of a gripper; 0: its nominal
  };
  void move_hand(const HandGoal& goal);
  void cancel_hand();
  /// How the last motion ended; none while it goes on, or where there was none.
  struct HandEnd {
    bool reached = false, blocked = false;
    std::string reason;
  };
  std::optional<HandEnd> hand_end();
  bool hand_is_moving() const { return hand_moves_; }
  /// Whether somebody serves the hand's action within `patience` [s].
  bool hand_is_served(double patience) const;
  const char* hand_action() const { return has_gripper_ ? "/gripper/move" : "/hand/move"; }

 private:
  using Time = std::chrono::steady_clock::time_point;
  void take(const msgs::JointState& state);
  void say(std::string line);

  const robot::Platform platform_;
  const robot::KinematicChain chain_;
  const bool has_gripper_;
  std::vector<std::string> hand_names_;
  mutable std::mutex mutex_;  // guards what follows
  Joints joints_;
  Time arm_time_{}, hand_time_{}, emergency_time_{};
  std::string lacking_;
  std::map<std::string, std::pair<double, Time>> pads_;
  std::optional<msgs::EmergencyStop> emergency_;
  std::deque<std::string> news_;
  std::optional<HandEnd> hand_end_;
  int hand_goals_ = 0;
  std::atomic<bool> hand_moves_ = false;

  graph::Node node_;
  EmergencyStop emergency_stop_;
  graph::Publisher<msgs::JointCommand> arm_commands_, hand_commands_;
  graph::Publisher<msgs::GripperCommand> gripper_commands_;
  graph::ServiceClient<msgs::Empty, msgs::Acknowledge> stop_arm_, stop_hand_;
  Follow follow_;
  MoveHand move_hand_;
  MoveGripper move_gripper_;
  graph::GoalHandle<msgs::FollowTrajectoryResult> run_;
  bool run_is_cut_ = false;
  graph::GoalHandle<msgs::MoveHandResult> hand_goal_;
  graph::GoalHandle<msgs::MoveGripperResult> gripper_goal_;
  std::vector<graph::Subscription> subscriptions_;
};

/// The first SIGINT, SIGTERM or SIGHUP is noticed, a second SIGINT or SIGTERM has its default
/// effect.
void notice_interrupts();
bool interrupted();

}  // namespace prehend::tools
