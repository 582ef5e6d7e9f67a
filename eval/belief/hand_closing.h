#pragma once

#include <vector>

#include "prehend/belief/hand_evidence.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/grasp/closing/close_fingers.h"
#include "prehend/robot/closing_way.h"
#include "prehend/touch/hand_touch.h"

namespace prehend::eval {

/// How a hand went, and what its pads said at the end.
struct HandClosing {
  std::vector<belief::HandSample> way;
  std::vector<touch::PadFrame> frames;
  bool arrived = true;  // or it met the object before it was where it should close
};

/// Carries the open hand straight from X_WH_start to X_WH_end, no farther than to where it is
/// stopped by the object, which is fixed, and closes it there gently until its motors are stopped,
/// in simulation::RobotWorld with its table z = 0.
/// @param object_W null: there is none.
HandClosing close_hand(const grasp::HandToClose& hand, const robot::ClosingWay& closing,
                       const geometry::RigidTransform& X_WH_start,
                       const geometry::RigidTransform& X_WH_end,
                       const geometry::MeshQuery* object_W);

}  // namespace prehend::eval
