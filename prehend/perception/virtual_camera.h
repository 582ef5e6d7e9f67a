#pragma once

#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::perception {

/// Intrinsics that explain an organized cloud.
struct FittedCamera {
  geometry::PinholeCamera camera;  // of the cloud's size
  double rms = 0;                  // pixels, of the inliers' reprojection
  double inlier_share = 0;         // 0..1, finite points within 2 pixels
  bool x_flipped = false;          // the file's x runs left; negate it to get the optical frame
  bool y_flipped = false;          // the file's y runs up
};

/// Fits fx, cx and fy, cy of an organized cloud whose camera is at the origin by least squares
/// from pixel (u, v) and (x / |z|, y / |z|), with outliers dropped and refitted. Works for z > 0
/// and for z < 0. @throws geometry::InputError when the cloud is not organized or has too few
/// points or too little spread to tell; a cloud that is no pinhole image shows as a low
/// inlier_share.
FittedCamera fit_camera(const geometry::PointCloud& cloud);

/// Typical distance between neighbouring points [m]: the median, over at most 2000 points, of the
/// distance to the nearest other point. @throws geometry::InputError for fewer than two points.
double point_spacing(const geometry::PointCloud& cloud);

/// A camera at the origin of C that sees all of an unorganized `cloud_C`, with pixels about as
/// large as the point spacing, 64..1280 pixels wide, so that splatted masks have no holes.
/// @throws geometry::InputError when no point is in front of the camera.
geometry::PinholeCamera make_virtual_camera(const geometry::PointCloud& cloud_C);

/// A viewpoint X_FC from which the surface in `cloud_F` could have been seen: at 1.5 times the
/// cloud's extent from its centre (0.3 to 1.5 m), 30 degrees above the horizon given by `up_F`, at
/// the azimuth (of 24) from which most points are visible and the surface bulges towards the
/// camera.
geometry::RigidTransform plausible_viewpoint(const geometry::PointCloud& cloud_F,
                                             const Eigen::Vector3d& up_F);

/// For each pixel the index of the nearest point, -1 where there is none. Every point covers a
/// square of side `size` [m], at least a pixel.
geometry::Image<int> splat(const geometry::PointCloud& cloud_C,
                           const geometry::PinholeCamera& camera, double size);

/// Indices of the points that the camera can see: nothing is more than 6 * `spacing` [m] nearer in
/// their pixel when every point covers 2.5 * `spacing`. Points outside the image are not seen.
std::vector<int> visible_points(const geometry::PointCloud& cloud_C,
                                const geometry::PinholeCamera& camera, double spacing);

}  // namespace prehend::perception
