#pragma once

#include <cstdint>

#include "prehend/geometry/image.h"

namespace prehend::perception {

/// Knobs of refined_disparity(); the time is that of `iterations` + 1 passes over the image.
struct SubpixelOptions {
  int window = 13;     // pixels, odd, 3..31: side of the window that agrees; 0: nothing is moved
  int iterations = 3;  // 1..10
  double most = 0.75;  // pixels, > 0, that a disparity moves in all
  double texture = 1;  // (grey levels per pixel)^2, > 0: gradients' variance that counts half
  double edge = 1;     // pixels, > 0: windows whose disparities deviate by more are of two surfaces

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// `disparity` [pixels] of the left image without the lag of one-pass semi-global matching.
///
/// OpenCV's one pass sums costs from above and from the sides alone. On a surface whose disparity
/// changes from row to row, as a table's does, its answers are those of some rows above: tenths of
/// a pixel behind, which is millimetres of depth. What both images say of such a place is not.
/// Each disparity moves by less than a pixel to where a window of both images agrees best: Lucas
/// and Kanade's step ("An iterative image registration technique", IJCAI 1981) along the row, on
/// the right image as each pixel's own disparity shifts it, without the windows' means. Where there
/// is little texture it moves less; it moves forwards only, by what at most six rows make up, and
/// not at all where the images would agree less. What has an edge or unknown disparities (NaN) in
/// its window moves as its neighbours of the same surface do, if it has any.
/// O(pixels), whatever the window, but for pixels beside edges: these look at all of theirs.
/// Deterministic.
/// @throws std::invalid_argument for a bad option or images of different sizes.
geometry::Image<float> refined_disparity(const geometry::Image<std::uint8_t>& left,
                                         const geometry::Image<std::uint8_t>& right,
                                         const geometry::Image<float>& disparity,
                                         const SubpixelOptions& options = {});

}  // namespace prehend::perception
