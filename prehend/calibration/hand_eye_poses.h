#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "prehend/calibration/hand_eye.h"
#include "prehend/motion/path_planner.h"

namespace prehend::calibration {

struct PoseChoiceOptions {
  HandEyeOptions hand_eye;  // mount, noises, and the chain where offsets are to be found
  int poses = 15;           // >= 5
  int candidates = 400;     // free poses that see the board, of which is chosen, >= poses
  double most_tilt = 0.9;   // rad, of the board against the line of sight, 0 to 1.2
  /// Share of the image's shorter side that the board's longer side fills, as it is farthest away
  /// and nearest.
  double least_fill = 0.35, most_fill = 0.85;
  std::uint64_t seed = 1;
  motion::PathOptions path;
};

/// A pose to drive to, and the way there.
struct ChosenPose {
  robot::Positions q;
  geometry::RigidTransform X_BF = geometry::RigidTransform::Identity();
  motion::JointPath path;  // free, from the pose before (the first: from the start)
  double gain = 0;         // nats: by which it raised log det of the Fisher information
};

struct PoseChoice {
  std::vector<ChosenPose> poses;  // in the order of driving
  double log_det = 0;             // of the information of all, with the prior's
  int candidates = 0, tried = 0;  // free ones that see the board, of so many tried
};

/// Poses from which camera and board follow best: candidates look at the board from random sides,
/// are within reach and limits, free of collisions and have all of the board in the image; of them
/// the one that raises log det of the Fisher information of what is unknown most is taken, one
/// after the other (greedy D-optimal design; V. Fedorov, "Theory of optimal experiments", 1972;
/// for a submodular gain it is within 1 - 1/e of the best set). Then they are put in an order of
/// short ways and each way is planned; a pose to which there is none is left out and the next best
/// one taken.
/// @param guess where camera and board are about: to some cm and degrees.
/// @param chain from base B to flange F, of `space`'s joints.
/// @throws geometry::InputError when there are fewer candidates than poses, saying why (out of
/// reach, touching, out of the image), or when ways to too few of them are found;
/// std::invalid_argument for a bad option.
PoseChoice choose_poses(const robot::KinematicChain& chain, const motion::FreeSpace& space,
                        const robot::Positions& start, const HandEyeUnknowns& guess,
                        const CalibrationBoard& board, const perception::CameraCalibration& camera,
                        const PoseChoiceOptions& options = {});

/// log det of the prior's and these poses' information, as choose_poses() raises it.
double information_log_det(const std::vector<geometry::RigidTransform>& X_BF,
                           const std::vector<robot::Positions>& q, const HandEyeUnknowns& guess,
                           const CalibrationBoard& board,
                           const perception::CameraCalibration& camera,
                           const HandEyeOptions& options);

}  // namespace prehend::calibration
