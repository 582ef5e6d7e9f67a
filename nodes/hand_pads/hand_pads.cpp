#include "nodes/hand_pads/hand_pads.h"

#include "msgs/convert/pad_touch.h"
#include "nodes/platform_source/platform_source.h"
#include "prehend/robot/grip.h"
#include "prehend/robot/robot_files.h"

namespace prehend::nodes {
namespace {

robot::Platform declared_platform(graph::Node& node) {
  const auto platform = node.declare_parameter<std::string>(
      {.name = "platform",
       .default_value = "stage_pg70",
       .description = "the robot whose pads feel, its name (stage_pg70, kr5_sdh, ...) or file",
       .read_only = true});
  return robot::read_platform(robot::platform_file(declare_platforms(node), platform));
}

}  // namespace

HandPads::HandPads(graph::Node& node)
    : platform_(declared_platform(node)),
      threshold_(node.declare_parameter<int>({.name = "threshold",
                                              .default_value = robot::kTouchCounts,
                                              .unit = "counts",
                                              .minimum = 0,
                                              .maximum = 65535,
                                              .description = "a texel that says more is touched",
                                              .read_only = true})),
      gripper_(node) {
  if (is_gripper()) gripper_.listen();
}

std::string HandPads::said_by() const {
  const auto said = gripper_.model();
  return said ? said->name : std::string();
}

touch::FeltPad HandPads::felt(const robot::HandPad& pad, const msgs::TactileFrame& frame) const {
  robot::HandPad sent = pad;
  if (const auto said = gripper_.model()) sent.model = said->pad;
  // The frames of a stage's gripper have the gripper's x from left to right on both its pads.
  const bool mirrored = is_gripper() && pad.name == "right";
  touch::FeltPad felt = convert::felt_pad(frame, sent, mirrored);
  felt.threshold = threshold_;
  return felt;
}

}  // namespace prehend::nodes
