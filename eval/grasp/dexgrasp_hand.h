#pragma once

#include <vector>

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/grasp/closing/close_fingers.h"
#include "prehend/robot/hand_model.h"
#include "prehend/simulation/robot_bodies.h"

namespace prehend::eval {

/// A hand, ready to be planned with and to be put into physics engines.
struct DexHand {
  /// Fingers that rub with `friction` in place of what the hand's file says, as a benchmark has it.
  /// @throws geometry::InputError as simulation::make_robot_bodies() and grasp::HandToClose.
  DexHand(robot::HandModel hand, double friction);
  DexHand(const DexHand&) = delete;
  DexHand& operator=(const DexHand&) = delete;

  robot::HandModel model;
  /// The same with a motor at each joint that engines move by itself: no coupling breaks away.
  robot::HandModel freed;
  grasp::HandToClose to_close;  // of `model`
  simulation::RobotBodies
      bodies;  // root at the origin, joints at 0, faces of pads as hard as links
  std::vector<std::vector<geometry::TriangleMesh>> pieces_B;  // convex, of each body
};

}  // namespace prehend::eval
