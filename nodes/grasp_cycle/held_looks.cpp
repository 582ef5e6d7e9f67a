#include "nodes/grasp_cycle/held_looks.h"

#include <algorithm>

#include <fmt/format.h>

#include "msgs/convert/geometry.h"
#include "prehend/control/hand_sample.h"

namespace prehend::nodes {
namespace {

const std::string kNotKnown = "where hand and joints are is not known";
// For answers, which have a patience of their own.
constexpr std::chrono::seconds kLookPatience{120};  // a mesh is made, beside whatever else runs
constexpr std::chrono::seconds kViewPatience{8};

void set_pose(const belief::HandSample& hand, msgs::HandPose* message) {
  *message->mutable_x_wh() = convert::to_message(hand.X_WH);
  for (const double position : hand.joints) message->add_position(position);
}

}  // namespace

using control::MotionStatus;

HeldGoals::HeldGoals(graph::Node& node, const robot::Platform& platform)
    : node_(node), platform_(platform), chain_(platform.arm_chain()) {}

void HeldGoals::hold(std::int64_t stamp, std::uint32_t object_id) {
  stamp_ = stamp;
  object_id_ = object_id;
}

std::optional<msgs::HeldLookGoal> HeldGoals::look(const control::ArmPercepts& gripped,
                                                  const control::ArmPercepts& now) const {
  const std::optional<belief::HandSample> then = hand_sample(platform_, chain_, gripped),
                                          here = hand_sample(platform_, chain_, now);
  if (!then || !here) return std::nullopt;
  msgs::HeldLookGoal goal;
  goal.set_stamp(stamp_);
  goal.set_object_id(object_id_);
  goal.set_since(node_.clock().now());
  set_pose(*then, goal.mutable_gripped());
  set_pose(*here, goal.mutable_held());
  for (const robot::ChainJoint& joint : chain_.joints()) {
    const auto found = std::find(now.names.begin(), now.names.end(), joint.name);
    goal.add_arm_position(now.positions.at(static_cast<std::size_t>(found - now.names.begin())));
  }
  return goal;
}

HeldLooks::HeldLooks(graph::Node& node, const HeldGoals& goals)
    : goals_(goals), goal_(node, "/held/look") {}

void HeldLooks::look(const control::ArmPercepts& gripped, const control::ArmPercepts& now) {
  goal_.stop();
  asked_ = false;
  const std::optional<msgs::HeldLookGoal> goal = goals_.look(gripped, now);
  found_ = goal ? "no look has come yet" : kNotKnown;
  if (!goal) return;
  goal_.send(*goal);
  asked_ = true;
  asked_at_ = std::chrono::steady_clock::now();
}

MotionStatus HeldLooks::failed(const std::string& why) {
  stop();
  asked_ = false;
  found_ = "/held/look: " + why;
  return MotionStatus::kFailed;
}

MotionStatus HeldLooks::status() {
  if (!asked_) return MotionStatus::kFailed;
  const auto outcome = goal_.end();
  if (!outcome) {
    if (std::chrono::steady_clock::now() - asked_at_ < kLookPatience) return MotionStatus::kMoving;
    return failed(fmt::format("no look came within {} s", kLookPatience.count()));
  }
  if (!outcome->ok()) return failed(outcome->error());
  found_ = (*outcome)->text();
  return (*outcome)->taken() ? MotionStatus::kReached : MotionStatus::kFailed;
}

LiftViews::LiftViews(graph::Node& node, const HeldGoals& goals)
    : node_(node), goals_(goals), goal_(node, "/percepts/view") {}

void LiftViews::look(const control::ArmPercepts& gripped, const control::ArmPercepts& now) {
  stop();
  view_.reset();
  if (!asks_) return;
  const std::optional<msgs::HeldLookGoal> goal = goals_.look(gripped, now);
  if (!goal) return failed(kNotKnown);
  found_ = "no view has come yet";
  goal_.send(*goal);
  waits_ = true;
  asked_at_ = std::chrono::steady_clock::now();
}

MotionStatus LiftViews::status() {
  if (!waits_) return view_ ? MotionStatus::kReached : MotionStatus::kFailed;
  const auto outcome = goal_.end();
  if (!outcome) {
    if (std::chrono::steady_clock::now() - asked_at_ < kViewPatience) return MotionStatus::kMoving;
    asks_ = false;
    failed("nobody answers /percepts/view, and nobody is asked any more");
  } else if (!outcome->ok()) {
    asks_ = false;
    failed(outcome->error() + "; nobody is asked any more");
  } else if (!(*outcome)->problem().empty()) {
    failed((*outcome)->problem());
  } else {
    waits_ = false;
    view_ = (*outcome)->view();
    found_ = "it was seen";
  }
  return view_ ? MotionStatus::kReached : MotionStatus::kFailed;
}

void LiftViews::failed(const std::string& why) {
  stop();
  found_ = why;
  node_.report(graph::Health::kWarning, "what was lifted is not seen: " + why);
}

void LiftViews::stop() {
  goal_.stop();
  waits_ = false;
}

std::optional<msgs::PerceivedView> LiftViews::take() {
  std::optional<msgs::PerceivedView> view = std::move(view_);
  view_.reset();
  return view;
}

}  // namespace prehend::nodes
