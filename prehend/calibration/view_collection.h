#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "prehend/calibration/board_view.h"

namespace prehend::calibration {

/// A view with fewer corners is not used.
inline constexpr std::size_t kLeastViewCorners = 6;

/// What views of a board must have together for a camera's calibration.
struct CollectionGoal {
  int views = 20;         // with the board, >= 4
  double tilt = 0.35;     // rad, of the board to each of four sides
  double coverage = 0.8;  // 0..1, of a 5 x 5 raster of the image, cells with a corner in a view
};

/// What is still missing of the goal, a phrase each: "6 more views", "corners in the upper left of
/// the image", "the board tilted about its vertical axis". Empty: nothing. The tilt is estimated
/// with a focal length as long as the image is wide.
std::vector<std::string> still_missing(const std::vector<BoardView>& views,
                                       const CalibrationBoard& board, int width, int height,
                                       const CollectionGoal& goal = {});

/// Normals of the board in the optical frame by each view's homography, for a camera whose focal
/// length is `focal` [pixels] and principal point the image's middle. Views with fewer than six
/// corners or corners in a line give (0, 0, 0).
std::vector<Eigen::Vector3d> board_normals(const std::vector<BoardView>& views,
                                           const CalibrationBoard& board, int width, int height,
                                           double focal);

/// Refuses what determines no camera: "board not found" (in no image), "too few views" (fewer than
/// `least` with six corners or more), "all views parallel" (planes that are parallel give one
/// vanishing line and so two equations for five unknowns; Z. Zhang, "A flexible new technique for
/// camera calibration", PAMI 22(11), 2000, section 4), "corners in the image's middle alone"
/// (nothing says what the lens does outside).
/// @throws DegenerateData
void require_views(const std::vector<BoardView>& views, const CalibrationBoard& board, int width,
                   int height, int least = 4);

}  // namespace prehend::calibration
