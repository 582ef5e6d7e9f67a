#pragma once

#include <optional>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/perception/segmented_scene.h"

namespace prehend::perception {

struct DarkBackgroundOptions {
  /// Grey level (largest of a pixel's channels) above which a pixel is an object's; 0: chosen by
  /// Otsu's method.
  int threshold = 0;          // 0..254
  int open_radius = 2;        // pixels: thinner things are reflections, 0..50
  int close_radius = 4;       // pixels: narrower gaps within an object are closed, 0..50
  int min_points = 200;       // with depth, of an object
  double max_distance = 2.5;  // m from the camera
  /// Points farther than this from the object's median depth are wrong matches [m].
  double max_depth_spread = 0.3;
  int max_objects = 20;
};

/// Objects before a black background, as in the set-up with a black cloth that the paper's second
/// robot used: what is bright is object, and no table can be seen, since black gives no stereo. The
/// table is the plane perpendicular to up under the lowest points (1 % quantile) of all objects.
/// @param cloud_C organized, in the optical frame of `camera`. @param image of the same size.
/// @param up_C direction away from the table; default: the camera's own up, -y, or the world's z
/// when X_WC is given. @param X_WC as in segment_on_table.
/// @throws geometry::InputError when nothing is bright ("is the background black?"), nothing is
/// dark, or no bright region has enough points with depth; std::invalid_argument for a bad option
/// or images of other sizes.
SegmentedScene segment_on_dark_background(
    const geometry::PointCloud& cloud_C, const geometry::ColorImage& image,
    const geometry::PinholeCamera& camera,
    const std::optional<Eigen::Vector3d>& up_C = std::nullopt,
    const std::optional<geometry::RigidTransform>& X_WC = std::nullopt,
    const DarkBackgroundOptions& options = {});

}  // namespace prehend::perception
