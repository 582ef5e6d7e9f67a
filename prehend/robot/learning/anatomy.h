#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/robot/hand_model.h"
#include "prehend/robot/learning/said.h"

namespace prehend::robot::learning {

/// Where a finger presses: in the middle of the inner surface of its last link.
struct FingerPad {
  int link = -1;                                        // of the model
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();        // m, in the link's frame
  Eigen::Vector3d normal_L = Eigen::Vector3d::UnitZ();  // unit, out of the surface
};

struct FoundFinger {
  std::string name;
  std::vector<int> links;     // from the palm's side to the tip
  std::vector<int> closing;   // motors (indices of HandModel::actuated) that curl it, or slide it
  std::vector<int> turning;   // motors that turn it otherwise: spread it, oppose it
  std::vector<double> sense;  // of `closing`: the sign that closes
  int base = -1;              // joint (of the model) that moves it and is nearest to the palm
  FingerPad pad;
  /// It presses where it moves as all its motors close, with what of its tip is ahead then, and not
  /// with its pad alone: one motor closes it and turns its pad by more than a radian, or its pad
  /// never lies flat against another.
  bool presses_ahead = false;
  double length = 0;  // m, from its first joint to the farthest point of its tip
};

/// How a hand is built, found from kinematics and shapes alone.
struct Anatomy {
  std::vector<FoundFinger> fingers;
  std::vector<int> linkage;  // links that move with a finger and are none's, as of a parallel drive
  Eigen::Vector3d center_H = Eigen::Vector3d::Zero();   // m: middle of where fingertips get to
  std::vector<Eigen::Vector3d> palm_H, palm_normals_H;  // points [m] of the palm's surface
  std::vector<Said> said;
};

/// Finds fingers, what closes them, and their inner surfaces.
///
/// A finger ends where no joint moves anything beyond it; ends that one motor moves and that stay
/// within 4 mm of each other are one (a parallel drive), the farther one is its tip. Hinges of a
/// chain whose axes are parallel to its last one's (within 30 degrees) curl it, others turn it. It
/// closes in the sense in which its tip comes nearer to the middle of where all fingertips get to.
/// Its inner surface is what moves ahead then, within 45 degrees: swept, not guessed from names.
/// @throws geometry::InputError for less than two fingers.
/// @param hand its model, palm and actuated joints; all joints that move have limits
Anatomy find_anatomy(const HandModel& hand);

}  // namespace prehend::robot::learning
