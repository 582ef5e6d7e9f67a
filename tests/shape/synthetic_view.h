#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "prehend/geometry/mesh_query.h"
#include "prehend/shape/completed_shape.h"

namespace prehend::shape {

/// A view that owns what ObjectView refers to.
struct SyntheticView {
  geometry::PointCloud cloud_W;
  geometry::MaskImage mask;
  geometry::PinholeCamera camera;
  geometry::RigidTransform X_WC;
  geometry::Plane table_W;
  geometry::DepthImage nearer;
  geometry::DepthImage depth;  // of the object and of the table

  ObjectView view() const { return {cloud_W, mask, camera, X_WC, table_W, &nearer, false, &depth}; }
};

struct ViewOptions {
  double elevation = 0.7;  // rad, of the camera over the object's centre
  double azimuth = 0;      // rad, of the camera about the table's normal
  double distance = 0.7;   // m, camera to centre
  double depth_noise = 0;  // m, standard deviation along the ray
  int width = 640;         // pixels; 4:3
  std::uint32_t seed = 1;
};

/// What an ideal camera sees of `mesh_W`, one point per pixel; the table is z = the mesh's bottom.
inline SyntheticView synthetic_view(const geometry::TriangleMesh& mesh_W,
                                    const ViewOptions& options) {
  const Eigen::AlignedBox3d box = geometry::bounds(mesh_W);
  const Eigen::Vector3d center = box.center();
  SyntheticView result;
  result.table_W.offset = box.min().z();
  const Eigen::Vector3d towards(std::cos(options.elevation) * std::cos(options.azimuth),
                                std::cos(options.elevation) * std::sin(options.azimuth),
                                std::sin(options.elevation));
  result.X_WC = geometry::look_at(center + options.distance * towards, center);
  auto& camera = result.camera;
  camera.width = options.width;
  camera.height = options.width * 3 / 4;
  camera.fx = camera.fy = 0.9 * options.width;
  camera.cx = 0.5 * (camera.width - 1);
  camera.cy = 0.5 * (camera.height - 1);
  result.mask = geometry::MaskImage(camera.width, camera.height, 0);
  result.depth =
      geometry::DepthImage(camera.width, camera.height, std::numeric_limits<float>::quiet_NaN());

  const geometry::MeshQuery query(mesh_W);
  std::mt19937 random(options.seed);
  const Eigen::Vector3d eye = result.X_WC.translation();
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray = (result.X_WC.linear() * camera.unproject(u, v, 1)).normalized();
      const double cosine = ray.dot(result.X_WC.linear().col(2));
      const auto hit = query.cast_ray(eye, ray);
      if (!hit) {
        const double to_table =
            -result.table_W.signed_distance(eye) / result.table_W.normal.dot(ray);
        if (to_table > 0) result.depth.at(u, v) = static_cast<float>(to_table * cosine);
        continue;
      }
      // Sum of uniform numbers: the same on every standard library.
      double noise = -6;
      for (int i = 0; i < 12; ++i) noise += random() / 4294967296.0;
      const double along = hit->distance + options.depth_noise * noise;
      result.cloud_W.points.push_back((eye + along * ray).cast<float>());
      result.mask.at(u, v) = 255;
      result.depth.at(u, v) = static_cast<float>(along * cosine);
    }
  }
  return result;
}

/// Puts something half as far away as the camera's target before the columns from `first` to
/// `last`: nothing is seen of the object there.
inline void hide_columns(SyntheticView& view, int first, int last, double depth) {
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  std::erase_if(view.cloud_W.points, [&](const Eigen::Vector3f& p_W) {
    const double u = view.camera.project(X_CW * p_W.cast<double>()).x();
    return u > first - 0.5 && u < last + 0.5;
  });
  view.nearer = geometry::DepthImage(view.camera.width, view.camera.height, 0.f);
  for (int v = 0; v < view.camera.height; ++v) {
    for (int u = std::max(0, first); u <= std::min(last, view.camera.width - 1); ++u) {
      view.mask.at(u, v) = 0;
      view.nearer.at(u, v) = static_cast<float>(depth);
      view.depth.at(u, v) = static_cast<float>(depth);
    }
  }
}

/// Everything of `view` moved by X_VW.
inline SyntheticView moved(const SyntheticView& view, const geometry::RigidTransform& X_VW) {
  SyntheticView result = view;
  result.cloud_W = geometry::transformed(view.cloud_W, X_VW);
  result.X_WC = X_VW * view.X_WC;
  result.table_W.normal = X_VW.linear() * view.table_W.normal;
  result.table_W.offset = view.table_W.offset + result.table_W.normal.dot(X_VW.translation());
  return result;
}

/// `mesh` turned by `yaw` [rad] about z and put on the plane z = 0, at (x, y) [m].
inline geometry::TriangleMesh standing(const geometry::TriangleMesh& mesh, double yaw, double x = 0,
                                       double y = 0) {
  geometry::RigidTransform turn = geometry::RigidTransform::Identity();
  turn.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  geometry::TriangleMesh turned = geometry::transformed(mesh, turn);
  geometry::RigidTransform lift = geometry::RigidTransform::Identity();
  lift.translation() = Eigen::Vector3d(x, y, -geometry::bounds(turned).min().z());
  return geometry::transformed(turned, lift);
}

}  // namespace prehend::shape
