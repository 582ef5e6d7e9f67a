#include "prehend/perception/points_over_table.h"

#include <algorithm>

#include "prehend/perception/cloud_partition.h"
#include "prehend/perception/organized_components.h"

namespace prehend::perception {

double least_height(const Table& table, const SegmentationOptions& options) {
  constexpr double kDeviations = 3.5;
  if (options.min_height > 0) return options.min_height;
  return std::clamp(kDeviations * table.rms, 0.004, 0.008);
}

double noise_growth(double depth) { return std::clamp(depth * depth, 1.0, 4.0); }

PointsOverTable points_over_table(const geometry::PointCloud& cloud_C,
                                  const geometry::PinholeCamera& camera, const Table& table,
                                  const SegmentationOptions& options) {
  std::vector<Eigen::Vector3f> corners;
  for (const Eigen::Vector3d& p : table.hull_C) corners.push_back(p.cast<float>());
  const PlaneOutline outline(table.plane_C, corners);
  PointsOverTable points;
  PointsLeftOut& left_out = points.left_out;
  left_out.least_height = least_height(table, options);
  for (std::size_t i = 0; i < cloud_C.size(); ++i) {
    if (!geometry::is_finite(cloud_C.points[i])) {
      ++left_out.not_finite;
      continue;
    }
    const Eigen::Vector3d p = cloud_C.points[i].cast<double>();
    const double height = table.plane_C.signed_distance(p);
    if (height < left_out.least_height * noise_growth(p.z())) {
      ++left_out.low;
    } else if (height > options.max_height) {
      ++left_out.over_max_height;
    } else if (p.norm() > options.max_distance) {
      ++left_out.too_far;
    } else if (!outline.contains(p, options.hull_margin)) {
      ++left_out.beside_table;
    } else {
      points.indices.push_back(static_cast<int>(i));
    }
  }
  if (!cloud_C.organized()) return points;
  // They would bridge what stands apart.
  const std::size_t all = points.indices.size();
  points.indices =
      without_flying_points(cloud_C, points.indices, options.cluster_tolerance, camera.fx);
  left_out.flying = all - points.indices.size();
  return points;
}

}  // namespace prehend::perception
