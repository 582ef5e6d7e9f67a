#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/image.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::geometry {

/// Points with optional colour and normals. Organized clouds are row-major images of points
/// (width x height); others have height 1 or 0. Invalid points are NaN in all three coordinates.
struct PointCloud {
  std::vector<Eigen::Vector3f> points;   // n, m
  std::vector<Rgb> colors;               // n or empty
  std::vector<Eigen::Vector3f> normals;  // n unit vectors or empty
  int width = 0;                         // organized: columns; else 0
  int height = 0;                        // organized: rows; else 0

  std::size_t size() const { return points.size(); }
  bool empty() const { return points.empty(); }
  bool organized() const {
    return height > 1 && static_cast<std::size_t>(width) * height == points.size();
  }
};

/// True when all three coordinates are finite.
inline bool is_finite(const Eigen::Vector3f& p) { return p.allFinite(); }

/// The finite points of `cloud` (with their colours and normals), unorganized.
PointCloud without_invalid(const PointCloud& cloud);

/// The points named by `indices`, in that order, unorganized. @pre indices are within the cloud.
PointCloud select(const PointCloud& cloud, const std::vector<int>& indices);

/// The cloud expressed in frame A, given X_AB and the cloud in frame B; keeps the organization.
PointCloud transformed(const PointCloud& cloud_B, const RigidTransform& X_AB);

/// Mean of the finite points [m]; zero for a cloud without any.
Eigen::Vector3d centroid(const PointCloud& cloud);

}  // namespace prehend::geometry
