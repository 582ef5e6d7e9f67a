#pragma once

#include <string>
#include <vector>

#include "prehend/simulation/robot_world.h"

namespace prehend::simulation {

/// A motion of a hand as somebody asks for it: names, and values in their order.
struct HandRequest {
  std::vector<std::string> joints;  // of the platform, or of the hand: without its prefix hand_
  std::vector<double> positions;    // rad or m
  double speed = 0.3;               // share of the joints' greatest, in (0, 1]
  bool until_contact = false;
  std::vector<double> efforts;  // N m or N, once they press; empty: what the joints can
};

struct NamedHandCommand {
  HandCommand command;      // joints that are not named stay where they are held
  std::vector<int> motors;  // of the named joints
};

/// The command to `world`'s hand. What is beyond limits RobotWorld::move_hand() refuses.
/// @throws std::invalid_argument in words: no joint, one that is not the hand's (with the nearest
/// name) or named twice, another number of values than of joints.
NamedHandCommand check_hand_request(const RobotWorld& world, const HandRequest& request);

/// A continuous command to a hand's joints as somebody asks for it.
struct JointsRequest {
  robot::JointMode mode = robot::JointMode::kStop;
  std::vector<std::string> joints;  // as of HandRequest; kStop: none means all
  std::vector<double> values;       // as many, by mode; none of kStop
};

/// The command to `world`'s hand. What is beyond limits RobotWorld::command_hand() refuses or cuts.
/// @throws std::invalid_argument in words: as check_hand_request().
MotorsCommand check_joints_request(const RobotWorld& world, const JointsRequest& request);

}  // namespace prehend::simulation
