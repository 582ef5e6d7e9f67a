#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "prehend/calibration/board_view.h"
#include "prehend/robot/kinematic_chain.h"

namespace prehend::calibration {

/// Where the camera is.
enum class CameraMount {
  kHand,   // on the flange F; the board stands in the base's frame B
  kWorld,  // stands in the base's frame B; the flange F carries the board
};

/// One pose of the arm and what the camera saw then.
struct HandEyePose {
  std::string name;
  geometry::RigidTransform X_BF = geometry::RigidTransform::Identity();  // as the arm says
  robot::Positions q;  // of the chain's joints, for joint offsets; else empty
  BoardView view;
};

/// What is to be found: P is the camera's place (F on the hand, B in the world), Q the board's (B
/// or F).
struct HandEyeUnknowns {
  geometry::RigidTransform X_PC = geometry::RigidTransform::Identity();
  geometry::RigidTransform X_QT = geometry::RigidTransform::Identity();
};

/// X_CT of the board when the flange is at X_BF.
geometry::RigidTransform board_in_camera(CameraMount mount, const HandEyeUnknowns& unknowns,
                                         const geometry::RigidTransform& X_BF);

struct HandEyeOptions {
  CameraMount mount = CameraMount::kHand;
  double pixel_noise = 0.1;      // pixels, > 0: standard deviation of a corner's u and v
  double position_noise = 1e-4;  // m, > 0: of the arm's pose about what it says, each axis
  double rotation_noise = 2e-4;  // rad, > 0
  int draws = 400;               // of three poses in the search for a consensus, >= 1
  std::uint64_t seed = 1;
  /// Of which the joints' zero offsets are to be found as well; null: none.
  const robot::KinematicChain* chain = nullptr;
};

/// One of OpenCV's solvers on the poses of the consensus.
struct SolverAnswer {
  std::string method;
  std::optional<HandEyeUnknowns> unknowns;  // none: it failed
  double rms = 0;                           // pixels
};

struct HandEyePoseFit {
  std::string name;
  bool used = false;
  std::string why_not;        // empty where it is used
  double rms = 0;             // pixels, of the corners, with the arm where it says it is
  double position_error = 0;  // m, of the board's middle, seen against predicted
  double rotation_error = 0;  // rad
};

/// Of a joint: true position = said position + offset.
struct JointOffset {
  std::string joint;
  double offset = 0;     // rad or m
  double deviation = 0;  // standard deviation
  /// False for the first and the last joint: no image tells their offsets from another place of
  /// board and camera, so theirs are 0.
  bool is_free = false;
};

struct HandEyeFit {
  HandEyeUnknowns unknowns;
  double position_deviation = 0;  // m, of X_PC, largest of the three axes
  double rotation_deviation = 0;  // rad
  double rms = 0;                 // pixels, over the used poses
  std::vector<SolverAnswer> solvers;
  std::vector<HandEyePoseFit> poses;
  std::vector<JointOffset> offsets;  // empty unless asked for
  std::vector<std::string> remarks;
};

/// Camera and board by poses of an arm, up to nearly half of them wrong (the board was knocked, an
/// image is of another pose):
///  1. the hypothesis from three poses (F. Park, B. Martin, IEEE T-RA 10(5), 1994) whose middle
///     pose reprojects best (P. Rousseeuw, "Least median of squares regression", JASA 79, 1984),
///     and the poses that agree with it;
///  2. all of OpenCV's solvers on these: Tsai, Park, Horaud, Andreff, Daniilidis for the camera,
///     Shah and Li for camera and board;
///  3. from the best of them on, least squares (Ceres) of corners' reprojection over X_PC, X_QT, a
///     small error of each of the arm's poses, with prior, and on request the joints' offsets;
///     poses that leave the consensus go, and the rest is fitted again.
/// @throws DegenerateData: "board not found", "too few poses" (fewer than five), "pure
/// translations", "rotation axes parallel" (R. Tsai, R. Lenz, IEEE T-RA 5(3), 1989: two rotations
/// about different axes are needed), "board symmetric", "no consensus" (fewer than half of the
/// poses agree), "joint offsets not determined"; std::invalid_argument for a bad option, or offsets
/// asked for of poses without positions.
HandEyeFit calibrate_hand_eye(const std::vector<HandEyePose>& poses, const CalibrationBoard& board,
                              const perception::CameraCalibration& camera,
                              const HandEyeOptions& options = {});

/// Refuses motions of the flange that determine no hand-eye pose. @throws DegenerateData "too few
/// poses", "pure translations", "rotation axes parallel".
void require_motions(const std::vector<geometry::RigidTransform>& X_BF);

}  // namespace prehend::calibration
