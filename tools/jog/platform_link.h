#pragma once

#include <memory>
#include <string>

#include "prehend/motion/robot_in_world.h"
#include "tools/jog/choices.h"
#include "tools/jog/find_platform.h"
#include "tools/jog/robot_link.h"

namespace prehend::tools {

/// The robot that a command is about, and its place in the graph.
struct PlatformLink {
  FoundPlatform found;
  robot::Platform platform;
  std::unique_ptr<RobotLink> link;
};

/// @throws as find_platform(), robot::read_platform() and RobotLink.
PlatformLink link_platform(const std::string& command, const JogChoices& choices);

/// The platform with its hand as it stands, among what the command line says is round it.
std::shared_ptr<const motion::RobotInWorld> space_of(const PlatformLink& robot,
                                                     const RobotLink::Joints& joints,
                                                     const JogChoices& choices);

/// The preshape of that name, or the hand's first. @throws geometry::InputError with the nearest.
const robot::Preshape& preshape_of(const robot::HandModel& hand, const std::string& name);

/// The hand opens as `preshape` has it; unnamed: the one that it is nearest to.
RobotLink::HandGoal open_goal(const RobotLink& link, const RobotLink::Joints& joints,
                              const std::string& preshape, double speed);
/// It closes, from where it stands, until it presses, with `force` [N] of each fingertip; 0: as it
/// can. By `preshape`, or, unnamed, the one that it is nearest to.
/// @throws std::invalid_argument for a force that it cannot, and where nobody tells how it stands.
RobotLink::HandGoal close_goal(const RobotLink& link, const RobotLink::Joints& joints,
                               const std::string& preshape, double speed, double force);

/// Motors' positions in words: "opening 34.0 mm" of a parallel gripper, or the joints.
std::string hand_text(const robot::HandModel& hand,
                      const Eigen::Ref<const Eigen::VectorXd>& positions);
/// Where the hand stands, the same; empty: nobody tells.
std::string hand_text(const RobotLink& link, const RobotLink::Joints& joints);
/// By what it can be told that the hand holds something, in words; empty: by nothing.
std::string holds_text(const RobotLink& link, const RobotLink::Joints& joints);
/// "pads: left 3.2 N, right 3.1 N"; of those that feel something; empty: none does.
std::string felt_text(const RobotLink& link);

}  // namespace prehend::tools
