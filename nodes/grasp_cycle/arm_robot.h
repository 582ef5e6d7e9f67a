#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "msgs/sensors.pb.h"
#include "nodes/grasp_cycle/arm_ports.h"
#include "nodes/grasp_cycle/gripper_ports.h"
#include "nodes/grasp_cycle/held_looks.h"
#include "nodes/grasp_cycle/view.h"
#include "nodes/gripper_source/gripper_source.h"
#include "prehend/control/arm_cycle.h"
#include "prehend/control/attempt_watch.h"
#include "prehend/control/pad_gripper.h"
#include "prehend/control/percept_watch.h"
#include "prehend/graph/node.h"
#include "prehend/robot/grip.h"
#include "prehend/robot/platform.h"

namespace prehend::nodes {

/// Declares the parameters of ArmCycleOptions but those of SharedCycleOptions.
control::ArmCycleOptions declare_arm_options(graph::Node& node);

/// The same of a gripper that regulates its grip, gripper_*.
control::PadGripperOptions declare_pad_gripper_options(graph::Node& node);

/// Who drives the gripper or hand: the simulation, or else a driver's name.
inline constexpr const char* kSimulated = "sim";
inline constexpr const char* kSdh = "sdh";
inline constexpr const char* kBarrett = "barrett";

/// @throws std::invalid_argument for parameters that were given but mean nothing for the platform,
/// and for one whose hand the gripper's driver cannot be.
void refuse_what_does_not_apply(const graph::Node& node, const robot::Platform& platform,
                                const std::string& gripper_driver);

/// What the cycle needs to know besides the plan.
struct ArmRobotOptions {
  control::ArmCycleOptions cycle;
  control::PadGripperOptions gripper;
  int touch_counts = robot::kTouchCounts;  // above: a texel is touched
  bool view_after_lift = false;            // what was lifted is looked at
};

/// A platform in the grasp cycle: its topics and actions, what of a plan it can execute, and the
/// control cycle that they feed. /arm/follow, /joint_states, /wrench and /tactile of its pads; its
/// hand is /hand/move, or a gripper: /gripper/move, /gripper/command, /gripper/state.
class ArmRobot {
 public:
  /// @param gripper that the robot says it has; kept. Of no platform but with a HandPort::kGripper.
  ArmRobot(graph::Node& node, const robot::Platform& platform, const GripperSource& gripper,
           const ArmRobotOptions& options);

  /// What it still has to hear before it can begin, in words; empty: nothing.
  std::string waits_for() const;
  /// What the grasp lacks to be executed, in words; empty: nothing.
  std::string lacks(const msgs::Grasp& grasp) const;
  /// Gets ready for the grasps of `target`, which has some. @return where the object is to be put,
  /// in words. @param first of the grasps, that is tried before the others, whatever the plan
  /// advises. @throws std::exception with the reason why they cannot be executed.
  std::string prepare(const View& view, const Target& target, std::optional<int> first = {});
  /// Gets ready for the push of a plan, as nothing can be grasped. @throws as prepare().
  void prepare_push(const msgs::GraspPlan& plan);
  /// Starts a cycle on what was prepared. `problem`: why it is no grasp. @throws as prepare().
  void start(const std::string& problem = "");
  /// The running cycle goes on with what was prepared. `problem` as start()'s.
  void take_prepared(const std::string& problem = "") {
    cycle_->take_plan(prepared_, problem, advice_);
  }
  /// A new look gave no grasp, for this reason.
  void take_nothing(const std::string& problem) { cycle_->take_plan({}, problem); }
  /// One step of the cycle on what the sensors say now.
  void step();
  control::Cycle& cycle() { return *cycle_; }
  const std::string& hand_name() const { return platform_.hand.name; }
  /// What the attempts of the running cycle find out.
  const control::AttemptWatch& attempt_watch() const { return *attempt_watch_; }
  /// What they perceive.
  const control::PerceptWatch& percept_watch() const { return *percept_watch_; }
  /// What a camera showed of what was lifted last, once; none: nobody looked, or it failed.
  std::optional<msgs::PerceivedView> take_lift_view() {
    return lift_views_ ? lift_views_->take() : std::nullopt;
  }

 private:
  bool has_gripper() const { return pad_gripper_ != nullptr; }
  void check_gripper(const msgs::GraspPlan& plan) const;
  control::ArmPercepts percepts() const;
  /// The pad that sent `frame`; null when it can be none of the hand's.
  std::shared_ptr<const touch::FeltPad> felt_pad(const std::string& name,
                                                 const msgs::TactileFrame& frame) const;

  graph::Node& node_;
  const GripperSource& gripper_;
  ArmActions arm_;
  std::unique_ptr<GripperActions> drive_;    // of a gripper
  std::unique_ptr<control::HandPort> hand_;  // a PadGripper or HandActions
  control::PadGripper* pad_gripper_ = nullptr;
  std::optional<control::ArmCycle> cycle_;
  robot::Platform platform_;
  HeldGoals held_;
  double contact_force_, touch_force_;  // N
  std::optional<control::AttemptWatch> attempt_watch_;
  std::optional<control::PerceptWatch> percept_watch_;
  std::vector<graph::Subscription> subscriptions_;
  std::shared_ptr<const msgs::JointState> joints_;
  std::shared_ptr<const msgs::GripperState> gripper_state_;
  std::optional<Eigen::Vector3d> wrist_force_, wrist_torque_;  // N, N m
  std::int64_t wrist_stamp_ = 0;                               // ns
  int touch_counts_;
  std::map<std::string, std::shared_ptr<const msgs::TactileFrame>> pads_;  // that have spoken
  std::map<std::string, robot::HandPad> hand_pads_;                        // all, by name
  /// As their frames are, and what of the frames they were made for.
  struct Felt {
    std::string made_for;
    std::shared_ptr<const touch::FeltPad> pad;
  };
  mutable std::map<std::string, Felt> felt_;
  std::optional<HeldLooks> held_looks_;  // of a task that inspects
  std::optional<LiftViews> lift_views_;
  std::vector<control::ArmGrasp> prepared_;
  control::Advice advice_;  // of their plan
};

}  // namespace prehend::nodes
