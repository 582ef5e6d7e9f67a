#pragma once

#include <cstdint>
#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::shape {

/// What completion needs of one object seen from one view. All geometry in one frame W (any frame).
struct ObjectView {
  const geometry::PointCloud& cloud_W;  // seen points, finite
  const geometry::MaskImage& mask;      // whole image, 255 where the object is seen
  const geometry::PinholeCamera& camera;
  const geometry::RigidTransform& X_WC;  // optical frame in W
  const geometry::Plane& table_W;        // normal towards the object
};

enum class PointOrigin : std::uint8_t { kSeen = 0, kMirrored = 1 };

/// One vertical plane of symmetry and how well it agrees with what was seen.
struct SymmetryHypothesis {
  Eigen::Vector3d point_W = Eigen::Vector3d::Zero();    // on the plane [m]
  Eigen::Vector3d normal_W = Eigen::Vector3d::UnitX();  // unit, parallel to the table
  double vote = 0;  // smaller is better
};

/// The seen points followed by their mirror images.
struct CompletedShape {
  geometry::PointCloud cloud_W;
  std::vector<PointOrigin> origin;  // one per point
  SymmetryHypothesis symmetry;      // the winner
  std::vector<SymmetryHypothesis> hypotheses;  // all that were tried, best first
  Eigen::Vector3d viewpoint_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d mirrored_viewpoint_W = Eigen::Vector3d::Zero();
};

}  // namespace prehend::shape
