#include "prehend/geometry/point_cloud.h"

namespace prehend::geometry {

PointCloud select(const PointCloud& cloud, const std::vector<int>& indices) {
  PointCloud out;
  out.points.reserve(indices.size());
  for (int i : indices) out.points.push_back(cloud.points[i]);
  if (!cloud.colors.empty()) {
    out.colors.reserve(indices.size());
    for (int i : indices) out.colors.push_back(cloud.colors[i]);
  }
  if (!cloud.normals.empty()) {
    out.normals.reserve(indices.size());
    for (int i : indices) out.normals.push_back(cloud.normals[i]);
  }
  return out;
}

PointCloud without_invalid(const PointCloud& cloud) {
  std::vector<int> valid;
  valid.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (is_finite(cloud.points[i])) valid.push_back(static_cast<int>(i));
  }
  return select(cloud, valid);
}

PointCloud transformed(const PointCloud& cloud_B, const RigidTransform& X_AB) {
  PointCloud cloud_A = cloud_B;
  // In double: a float rotation of a cloud far from the origin would lose millimetres.
  for (auto& p : cloud_A.points) p = (X_AB * p.cast<double>()).cast<float>();
  for (auto& n : cloud_A.normals) n = (X_AB.linear() * n.cast<double>()).cast<float>();
  return cloud_A;
}

Eigen::Vector3d centroid(const PointCloud& cloud) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (const auto& p : cloud.points) {
    if (!is_finite(p)) continue;
    sum += p.cast<double>();
    ++count;
  }
  return count == 0 ? sum : Eigen::Vector3d(sum / static_cast<double>(count));
}

}  // namespace prehend::geometry
