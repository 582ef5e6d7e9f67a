#pragma once

#include <Eigen/Core>

namespace prehend::geometry {

/// An ideal (rectified, undistorted) pinhole camera. Pixel (0, 0) is the centre of the upper left
/// pixel; the optical frame C has x right, y down, z forward.
struct PinholeCamera {
  int width = 0;   // pixels
  int height = 0;  // pixels
  double fx = 0;   // focal lengths [pixels]
  double fy = 0;
  double cx = 0;  // principal point [pixels]
  double cy = 0;

  /// Pixel coordinates of `p_C` [m]. @pre p_C.z() > 0.
  Eigen::Vector2d project(const Eigen::Vector3d& p_C) const {
    return {fx * p_C.x() / p_C.z() + cx, fy * p_C.y() / p_C.z() + cy};
  }
  /// The point at depth `z` [m] seen in pixel (u, v).
  Eigen::Vector3d unproject(double u, double v, double z) const {
    return {(u - cx) / fx * z, (v - cy) / fy * z, z};
  }
};

/// A rectified stereo pair: both cameras are `left`; the right one is displaced by `baseline` along
/// +x of the left optical frame, so disparity = fx * baseline / z.
struct StereoCamera {
  PinholeCamera left;
  double baseline = 0;  // m, > 0
};

}  // namespace prehend::geometry
