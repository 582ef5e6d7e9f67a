#pragma once

#include "prehend/geometry/image.h"

namespace prehend::perception {

/// Knobs of the edge-preserving filter. `smoothness` and `color_scale` decide how far a disparity
/// spreads; the time is that of `iterations` passes over the image.
struct DisparityFilterOptions {
  double smoothness = 1000;  // lambda of the weighted least squares, > 0
  double color_scale = 1.0;  // grey levels: a step of the guide of this size weakens a tie by 1/e
  int iterations = 3;        // of a pass along rows and one along columns, 1..10
  /// Pixels whose neighbourhood had less confidence than this stay unknown, 0..1. The filter has
  /// an answer everywhere; far from any match it is an invention.
  double min_support = 0.05;
};

/// Weighted least squares filter of a disparity image (or any other quantity):
///
///     minimise  sum_p c_p (u_p - d_p)^2 + lambda sum_(p,q) exp(-|g_p - g_q| / sigma) (u_p - u_q)^2
///
/// over neighbours (p, q), with d the disparity, c its confidence (0 where d is NaN) and g the
/// guide, by rows and columns in turn, each a tridiagonal system solved exactly (Min, Choi, Lu,
/// Ham, Sohn, Do: "Fast Global Image Smoothing Based on Weighted Least Squares", TIP 2014).
/// Fills small holes up to edges of the guide and smoothes within them. Smoothed c d over smoothed
/// c, as in OpenCV's DisparityWLSFilter. O(pixels).
/// @throws std::invalid_argument for a bad option or images of different sizes.
geometry::Image<float> filtered_disparity(const geometry::Image<float>& disparity,
                                          const geometry::Image<float>& confidence,
                                          const geometry::Image<std::uint8_t>& guide,
                                          const DisparityFilterOptions& options = {});

}  // namespace prehend::perception
