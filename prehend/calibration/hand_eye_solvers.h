#pragma once

#include <string>
#include <vector>

#include "prehend/calibration/hand_eye.h"

namespace prehend::calibration {

/// A pose of the flange and of the board in the camera then.
struct PosePair {
  geometry::RigidTransform X_BF = geometry::RigidTransform::Identity();
  geometry::RigidTransform X_CT = geometry::RigidTransform::Identity();
};

/// Names of OpenCV's solvers: five for the camera, two for camera and board.
const std::vector<std::string>& hand_eye_solvers();

/// By one of them. Where a solver gives no board, it is the mean of what the poses say. None when
/// it fails or its answer is not finite. @pre three pairs or more.
std::optional<HandEyeUnknowns> solve_hand_eye(const std::string& solver, CameraMount mount,
                                              const std::vector<PosePair>& pairs);

}  // namespace prehend::calibration
