#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::shape {

/// How far a view saw, pixel by pixel: what lies clearly before that is empty.
struct SeenSpace {
  geometry::PinholeCamera camera;    // of a window of the view's image
  geometry::RigidTransform X_WC;     // pose of its optical frame in W
  geometry::DepthImage empty_until;  // of the camera's size [m]; NaN where nothing is known
};

/// The part of a view that the points (frame W) project into and `margin` pixels round it.
/// `empty_until` is the least depth that was measured within two pixels: edges are no surer than
/// that, in stereo as with structured light. Where the bare table was seen, farther than 8 mm (and
/// two pixels) from anything else, it reaches 5 cm beyond: nothing stands there, be it ever so low.
/// No size when none of the points is in the image. @pre `depth` is of the camera's size.
SeenSpace make_seen_space(const geometry::DepthImage& depth, const geometry::PinholeCamera& camera,
                          const geometry::RigidTransform& X_WC, const geometry::Plane& table_W,
                          const std::vector<Eigen::Vector3f>& points_W, int margin);

/// How far `p_C`, in the camera's optical frame, lies before what was seen behind it [m]: > 0 in
/// empty space, < 0 behind a surface, minus infinity where nothing is known. O(1).
double depth_in_empty_space(const SeenSpace& space, const Eigen::Vector3d& p_C);

}  // namespace prehend::shape
