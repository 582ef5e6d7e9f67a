#include "nodes/grasp_cycle/held_looks.h"

#include <algorithm>
#include <optional>

#include "msgs/convert/geometry.h"
#include "prehend/control/hand_sample.h"

namespace prehend::nodes {
namespace {

void set_pose(const belief::HandSample& hand, msgs::HandPose* message) {
  *message->mutable_x_wh() = convert::to_message(hand.X_WH);
  for (const double position : hand.joints) message->add_position(position);
}

}  // namespace

using control::MotionStatus;

HeldLooks::HeldLooks(graph::Node& node, const robot::Platform& platform)
    : node_(node), platform_(platform), chain_(platform.arm_chain()), goal_(node, "/held/look") {}

void HeldLooks::hold(std::int64_t stamp, std::uint32_t object_id) {
  stamp_ = stamp;
  object_id_ = object_id;
}

void HeldLooks::look(const control::ArmPercepts& gripped, const control::ArmPercepts& now) {
  goal_.stop();
  asked_ = false;
  const std::optional<belief::HandSample> then = hand_sample(platform_, chain_, gripped),
                                          here = hand_sample(platform_, chain_, now);
  if (!then || !here) {
    found_ = "where hand and joints are is not known";
    return;
  }
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
  found_ = "no look has come yet";
  goal_.send(goal);
  asked_ = true;
}

MotionStatus HeldLooks::status() {
  if (!asked_) return MotionStatus::kFailed;
  const auto outcome = goal_.end();
  if (!outcome) return MotionStatus::kMoving;
  if (!outcome->ok()) {
    found_ = "/held/look: " + outcome->error();
    return MotionStatus::kFailed;
  }
  found_ = (*outcome)->text();
  return (*outcome)->taken() ? MotionStatus::kReached : MotionStatus::kFailed;
}

}  // namespace prehend::nodes
