#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "msgs/belief.pb.h"
#include "msgs/percepts.pb.h"
#include "nodes/motion_goal/motion_goal.h"
#include "prehend/control/arm_ports.h"
#include "prehend/graph/node.h"
#include "prehend/robot/kinematic_chain.h"
#include "prehend/robot/platform.h"

namespace prehend::nodes {

/// What is held, and where everything is when somebody is asked to look at it.
class HeldGoals {
 public:
  /// `platform` lives longer.
  HeldGoals(graph::Node& node, const robot::Platform& platform);

  /// From now on it is this object, of the view with this stamp [ns].
  void hold(std::int64_t stamp, std::uint32_t object_id);
  /// None: where hand and joints are is not known.
  std::optional<msgs::HeldLookGoal> look(const control::ArmPercepts& gripped,
                                         const control::ArmPercepts& now) const;

 private:
  graph::Node& node_;
  const robot::Platform& platform_;
  robot::KinematicChain chain_;
  std::int64_t stamp_ = 0;
  std::uint32_t object_id_ = 0;
};

/// The action /held/look: who keeps the model of what is held looks at it.
class HeldLooks : public control::InspectionPort {
 public:
  /// `goals` lives longer.
  HeldLooks(graph::Node& node, const HeldGoals& goals);

  void look(const control::ArmPercepts& gripped, const control::ArmPercepts& now) override;
  control::MotionStatus status() override;
  std::string found() override { return found_; }
  void stop() override { goal_.stop(); }

 private:
  control::MotionStatus failed(const std::string& why);

  const HeldGoals& goals_;
  MotionGoal<msgs::HeldLookGoal, msgs::HeldLookFeedback, msgs::HeldLookResult> goal_;
  bool asked_ = false;
  std::chrono::steady_clock::time_point asked_at_;
  std::string found_;
};

/// The action /percepts/view: what was lifted is looked at, to compare it with what was foretold.
/// When nobody answers, nobody is asked any more.
class LiftViews : public control::InspectionPort {
 public:
  /// `goals` lives longer.
  LiftViews(graph::Node& node, const HeldGoals& goals);

  void look(const control::ArmPercepts& gripped, const control::ArmPercepts& now) override;
  control::MotionStatus status() override;
  std::string found() override { return found_; }
  void stop() override;
  /// Of the last look, once: none when there was none since, or it has failed.
  std::optional<msgs::PerceivedView> take();

 private:
  void failed(const std::string& why);

  graph::Node& node_;
  const HeldGoals& goals_;
  MotionGoal<msgs::HeldLookGoal, msgs::LiftViewFeedback, msgs::LiftViewResult> goal_;
  bool asks_ = true, waits_ = false;
  std::chrono::steady_clock::time_point asked_at_;
  std::optional<msgs::PerceivedView> view_;
  std::string found_;
};

}  // namespace prehend::nodes
