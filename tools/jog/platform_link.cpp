#include "tools/jog/platform_link.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/control/hand_motion.h"
#include "prehend/control/jog_space.h"

namespace prehend::tools {
namespace {

constexpr double kFelt = 0.3;           // N, of a pad's sum: touches
constexpr double kPadAge = 0.5;         // s
constexpr double kHoldingEffort = 0.2;  // share of a joint's greatest

// The named one; unnamed the one that the hand is nearest to, or its first.
const robot::Preshape& standing_preshape(const RobotLink& link, const RobotLink::Joints& joints,
                                         const std::string& name) {
  const robot::HandModel& hand = link.platform().hand;
  const bool told = joints.hand.size() == static_cast<std::size_t>(hand.size());
  if (!name.empty() || link.has_gripper() || !told) return preshape_of(hand, name);
  return control::nearest_preshape(
      hand, Eigen::Map<const Eigen::VectorXd>(joints.hand.data(), hand.size()));
}

}  // namespace

PlatformLink link_platform(const std::string& command, const JogChoices& choices) {
  graph::Introspection graph(choices.registry);
  PlatformLink robot{find_platform(graph, choices.platform), {}, nullptr};
  robot.platform = robot::read_platform(robot.found.file);
  robot.link = std::make_unique<RobotLink>(command, choices.registry, robot.platform);
  return robot;
}

std::shared_ptr<const motion::RobotInWorld> space_of(const PlatformLink& robot,
                                                     const RobotLink::Joints& joints,
                                                     const JogChoices& choices) {
  control::JogSurroundings around;
  around.table = table_height(choices.table);
  around.clearance = choices.clearance;
  return control::jog_space(robot.platform, robot.link->hand_positions(joints), around);
}

const robot::Preshape& preshape_of(const robot::HandModel& hand, const std::string& name) {
  return name.empty() ? hand.preshapes.front() : hand.preshape(name);
}

RobotLink::HandGoal open_goal(const RobotLink& link, const RobotLink::Joints& joints,
                              const std::string& preshape, double speed) {
  RobotLink::HandGoal goal;
  goal.positions = standing_preshape(link, joints, preshape).open;
  goal.speed = speed;
  return goal;
}

RobotLink::HandGoal close_goal(const RobotLink& link, const RobotLink::Joints& joints,
                               const std::string& preshape, double speed, double force) {
  const robot::HandModel& hand = link.platform().hand;
  RobotLink::HandGoal goal;
  goal.speed = speed;
  goal.until_contact = true;
  if (link.has_gripper()) {
    goal.positions = Eigen::VectorXd::Zero(1);
    if (force > 0) goal.current = control::current_for(*hand.gripper, force);
    return goal;
  }
  if (joints.hand.size() != static_cast<std::size_t>(hand.size())) {
    throw std::invalid_argument("nobody tells where the hand's joints are");
  }
  const Eigen::VectorXd now = Eigen::Map<const Eigen::VectorXd>(joints.hand.data(), hand.size());
  goal.positions = control::closed_positions(hand, standing_preshape(link, joints, preshape), now);
  if (force > 0) goal.efforts = control::efforts_for(hand, now, force);
  return goal;
}

std::string hand_text(const robot::HandModel& hand,
                      const Eigen::Ref<const Eigen::VectorXd>& positions) {
  // Of a parallel gripper the joint is half of it.
  if (hand.gripper) return fmt::format("opening {:.1f} mm", 2e3 * positions[0]);
  std::string text;
  for (int i = 0; i < hand.size(); ++i) {
    const robot::Joint& joint =
        hand.model.joints[static_cast<std::size_t>(hand.actuated[static_cast<std::size_t>(i)])];
    text += text.empty() ? "" : ", ";
    text += joint.kind == robot::Joint::Kind::kPrismatic
                ? fmt::format("{} {:.1f} mm", joint.name, 1e3 * positions[i])
                : fmt::format("{} {:.1f} deg", joint.name, positions[i] * 180 / M_PI);
  }
  return text;
}

std::string hand_text(const RobotLink& link, const RobotLink::Joints& joints) {
  if (joints.hand.empty()) return {};
  if (link.has_gripper()) {
    return hand_text(link.platform().hand, Eigen::VectorXd::Constant(1, joints.hand.front() / 2));
  }
  return hand_text(link.platform().hand,
                   Eigen::Map<const Eigen::VectorXd>(
                       joints.hand.data(), static_cast<Eigen::Index>(joints.hand.size())));
}

std::string holds_text(const RobotLink& link, const RobotLink::Joints& joints) {
  if (const std::string felt = felt_text(link); !felt.empty()) return felt;
  if (joints.gripper_blocked) return "the gripper is blocked";
  const robot::HandModel& hand = link.platform().hand;
  for (std::size_t i = 0; i < joints.hand_effort.size(); ++i) {
    const robot::Joint& joint = hand.model.joints[static_cast<std::size_t>(hand.actuated[i])];
    const double share = std::abs(joints.hand_effort[i]) / joint.max_effort;
    if (share > kHoldingEffort) {
      return fmt::format("joint '{}' presses with {:.0f} % of its effort", joint.name, 100 * share);
    }
  }
  return {};
}

std::string felt_text(const RobotLink& link) {
  std::string text;
  for (const RobotLink::Pad& pad : link.pads()) {
    if (pad.age > kPadAge || pad.force < kFelt) continue;
    text += fmt::format("{}{} {:.1f} N", text.empty() ? "pads: " : ", ", pad.name, pad.force);
  }
  return text;
}

}  // namespace prehend::tools
