#pragma once

#include <vector>

#include "prehend/calibration/hand_eye.h"

namespace prehend::calibration {

/// Least squares of some poses' corners.
struct HandEyeRefinement {
  HandEyeUnknowns unknowns;
  double position_deviation = 0, rotation_deviation = 0;  // of X_PC [m, rad], largest axis
  Eigen::VectorXd offsets, offset_deviations;             // of the chain's joints; empty without

  /// Where the flange is at `pose`, with the offsets.
  geometry::RigidTransform flange(const HandEyePose& pose,
                                  const robot::KinematicChain* chain) const;
};

/// From `start` on. Deviations are the covariance's (inverse of the normal matrix) times the
/// residuals' variance where that is above what the noises let expect.
/// @throws DegenerateData "joint offsets not determined" where the normal matrix is singular.
HandEyeRefinement refine_hand_eye(const std::vector<HandEyePose>& poses,
                                  const std::vector<int>& chosen, const HandEyeUnknowns& start,
                                  const CalibrationBoard& board,
                                  const perception::CameraCalibration& camera,
                                  const HandEyeOptions& options);

/// Fisher information of x_C, x_T (HandEyeResidual) and, with a chain, of the offsets of its joints
/// but the first and the last, by one pose: J^T (S + E)^-1 J, S of the corners' noise and E of the
/// arm's. Pixels of the view are not looked at, its ids are.
Eigen::MatrixXd pose_information(const HandEyePose& pose, const HandEyeUnknowns& guess,
                                 const CalibrationBoard& board,
                                 const perception::CameraCalibration& camera,
                                 const HandEyeOptions& options);

}  // namespace prehend::calibration
