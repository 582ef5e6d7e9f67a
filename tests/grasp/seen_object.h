#pragma once

#include <limits>
#include <random>

#include "prehend/geometry/mesh_query.h"
#include "prehend/grasp/known/known_objects.h"

namespace prehend::grasp {

inline constexpr double kDepthNoise = 0.0008;  // m, standard deviation

inline geometry::TriangleMesh moved(const geometry::TriangleMesh& mesh, const Eigen::Vector3d& by) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.translation() = by;
  return geometry::transformed(mesh, X);
}

/// An angle iron, 120 mm long.
inline geometry::TriangleMesh angle_iron() {
  return geometry::concatenated({moved(geometry::make_box({0.12, 0.06, 0.02}), {0, 0, 0.01}),
                                 moved(geometry::make_box({0.12, 0.02, 0.06}), {0, -0.02, 0.05})});
}

inline geometry::TriangleMesh bottle() {
  return geometry::make_revolution(
      {{0.03, 0}, {0.035, 0.01}, {0.035, 0.10}, {0.012, 0.14}, {0.012, 0.17}});
}

inline geometry::TriangleMesh carton() { return geometry::make_box({0.06, 0.09, 0.14}); }
inline geometry::TriangleMesh tall_carton() { return geometry::make_box({0.06, 0.09, 0.22}); }
inline geometry::TriangleMesh flat_carton() { return geometry::make_box({0.06, 0.09, 0.04}); }
inline geometry::TriangleMesh can() {
  return geometry::make_revolution({{0.033, 0}, {0.033, 0.1}});
}

/// Stands on the table z = 0 with its lowest point.
inline geometry::RigidTransform standing(const geometry::TriangleMesh& mesh, double yaw,
                                         const Eigen::Vector2d& at) {
  geometry::RigidTransform X_WO = geometry::RigidTransform::Identity();
  X_WO.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  X_WO.translation() << at, -geometry::bounds(mesh).min().z();
  return X_WO;
}

/// The object on a table as a depth camera at `eye_W` sees it.
inline SeenObject view_of(const geometry::TriangleMesh& mesh_O,
                          const geometry::RigidTransform& X_WO, const Eigen::Vector3d& eye_W,
                          std::uint64_t seed = 1) {
  SeenObject seen;
  seen.camera = {320, 240, 420, 420, 159.5, 119.5};
  seen.X_WC = geometry::look_at(eye_W, X_WO * geometry::bounds(mesh_O).center());
  seen.depth = geometry::DepthImage(320, 240, std::numeric_limits<float>::quiet_NaN());
  seen.table_W = geometry::Plane{};
  const geometry::MeshQuery object_W(geometry::transformed(mesh_O, X_WO));
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, kDepthNoise);
  for (int v = 0; v < seen.camera.height; ++v) {
    for (int u = 0; u < seen.camera.width; ++u) {
      const Eigen::Vector3d ray_C = seen.camera.unproject(u, v, 1);
      const Eigen::Vector3d ray_W = seen.X_WC.linear() * ray_C.normalized();
      const auto hit = object_W.cast_ray(eye_W, ray_W);
      const double to_table = ray_W.z() < 0 ? -eye_W.z() / ray_W.z() : 1e9;
      const bool is_object = hit && hit->distance < to_table;
      const double distance = is_object ? hit->distance : to_table;
      if (distance > 5) continue;
      const double z = distance / ray_C.norm() + noise(random);
      seen.depth.at(u, v) = static_cast<float>(z);
      if (!is_object) continue;
      const Eigen::Vector3d p_W = seen.X_WC * seen.camera.unproject(u, v, z);
      seen.cloud_W.points.push_back(p_W.cast<float>());
    }
  }
  return seen;
}

}  // namespace prehend::grasp
