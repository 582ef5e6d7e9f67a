#include "prehend/surface/shape_cloud.h"

#include <algorithm>
#include <utility>

#include <Eigen/Geometry>

#include "prehend/surface/closing.h"
#include "prehend/surface/vessel.h"

namespace prehend::surface {
namespace {

/// Whether there may be nothing between front and back; the other methods make sides themselves.
bool is_mirrored(shape::CompletionMethod method) {
  return method == shape::CompletionMethod::kMirror ||
         method == shape::CompletionMethod::kRefusedMirror;
}

/// The points of both sides of a vessel's wall.
ShapeCloud vessel_cloud(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                        const ShapeCloudOptions& options, double spacing) {
  constexpr double kNodesOfWall = 1.8;  // of the surface's grid, about one spacing apart
  OrientedCloudOptions apart = options.cloud;
  apart.separate_origins = true;
  ShapeCloud result;
  result.cloud_W = oriented_cloud(shape, apart, &result.origin);
  std::vector<bool> seen;
  for (const shape::PointOrigin origin : result.origin) {
    seen.push_back(origin == shape::PointOrigin::kSeen);
  }
  if (const auto basin = find_basin(result.cloud_W, table_W, spacing)) {
    add_vessel_walls(result.cloud_W, seen, *basin, spacing, kNodesOfWall * spacing);
  }
  result.origin.clear();
  for (const bool is_seen : seen) {
    result.basis.push_back(is_seen ? SurfaceOrigin::kSeen : SurfaceOrigin::kAssumed);
    result.origin.push_back(is_seen ? shape::PointOrigin::kSeen : shape::PointOrigin::kMirrored);
  }
  return result;
}

}  // namespace

double spacing_of(const geometry::PointCloud& cloud) {
  constexpr double kPointsAcross = 90;
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : cloud.points) box.extend(p);
  return static_cast<double>(box.sizes().maxCoeff()) / kPointsAcross;
}

ShapeCloud shape_cloud(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                       const ShapeCloudOptions& options) {
  ShapeCloud result;
  result.cloud_W = oriented_cloud(shape, options.cloud, &result.origin);
  const double spacing = std::max(spacing_of(result.cloud_W), options.cloud.least_spacing);
  if (options.hollow_vessels && find_basin(result.cloud_W, table_W, spacing)) {
    return vessel_cloud(shape, table_W, options, spacing);
  }
  for (const shape::PointOrigin origin : result.origin) {
    result.basis.push_back(origin == shape::PointOrigin::kSeen ? SurfaceOrigin::kSeen
                                                               : SurfaceOrigin::kPredicted);
  }
  if (options.close_sides && is_mirrored(shape.method)) {
    const geometry::PointCloud sides = side_points(shape, table_W, spacing);
    auto& points = result.cloud_W.points;
    auto& normals = result.cloud_W.normals;
    points.insert(points.end(), sides.points.begin(), sides.points.end());
    normals.insert(normals.end(), sides.normals.begin(), sides.normals.end());
    result.basis.resize(points.size(), SurfaceOrigin::kAssumed);
    result.origin.resize(points.size(), shape::PointOrigin::kMirrored);
  }
  return result;
}

}  // namespace prehend::surface
