#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"

// Views of tables, walls and boxes by exact ray casting, so that every answer is known.
namespace prehend::perception::testing {

/// An axis-aligned solid in the world [m].
struct Box {
  Eigen::Vector3d lower;
  Eigen::Vector3d upper;
};

/// A box of the given size standing on z = `bottom` around (x, y).
inline Box standing_box(double x, double y, const Eigen::Vector3d& size, double bottom = 0) {
  return {{x - size.x() / 2, y - size.y() / 2, bottom},
          {x + size.x() / 2, y + size.y() / 2, bottom + size.z()}};
}

struct SyntheticView {
  geometry::PinholeCamera camera{320, 240, 300, 300, 159.5, 119.5};
  geometry::RigidTransform X_WC = geometry::look_at({0, -0.8, 0.6}, {0, 0, 0});
  std::vector<Box> boxes;
  double noise = 0;  // m at 1 m depth, standard deviation, grows with depth squared
};

/// Distance along the ray to where it enters `box`.
inline std::optional<double> enter(const Box& box, const Eigen::Vector3d& origin,
                                   const Eigen::Vector3d& direction) {
  double first = 0;
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    double a = (box.lower[k] - origin[k]) / direction[k];
    double b = (box.upper[k] - origin[k]) / direction[k];
    if (a > b) std::swap(a, b);
    first = std::max(first, a);
    last = std::min(last, b);
  }
  if (!(first < last) || first <= 0) return std::nullopt;
  return first;
}

/// The box that each pixel sees, -1: none.
inline geometry::Image<int> owners(const SyntheticView& view, geometry::DepthImage& depth) {
  geometry::Image<int> owner(view.camera.width, view.camera.height, -1);
  depth = geometry::DepthImage(view.camera.width, view.camera.height,
                               std::numeric_limits<float>::quiet_NaN());
  for (int v = 0; v < view.camera.height; ++v) {
    for (int u = 0; u < view.camera.width; ++u) {
      const Eigen::Vector3d ray = view.X_WC.linear() * view.camera.unproject(u, v, 1.0);
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < view.boxes.size(); ++k) {
        const auto z = enter(view.boxes[k], view.X_WC.translation(), ray);
        if (!z || *z >= nearest) continue;
        nearest = *z;
        owner.at(u, v) = static_cast<int>(k);
        depth.at(u, v) = static_cast<float>(*z);
      }
    }
  }
  return owner;
}

/// Organized cloud in the optical frame.
inline geometry::PointCloud render(const SyntheticView& view, std::uint64_t seed = 1) {
  geometry::DepthImage depth;
  owners(view, depth);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  geometry::PointCloud cloud;
  cloud.width = view.camera.width;
  cloud.height = view.camera.height;
  for (int v = 0; v < view.camera.height; ++v) {
    for (int u = 0; u < view.camera.width; ++u) {
      double z = static_cast<double>(depth.at(u, v));
      z += view.noise * z * z * noise(random);
      cloud.points.push_back(view.camera.unproject(u, v, z).cast<float>());
      if (!std::isfinite(z)) {
        cloud.points.back().setConstant(std::numeric_limits<float>::quiet_NaN());
      }
    }
  }
  return cloud;
}

inline Box table_top(double width = 1.2, double depth = 0.9) {
  return {{-width / 2, -depth / 2, -0.03}, {width / 2, depth / 2, 0}};
}

/// A wall behind the table, much larger than it.
inline Box back_wall() { return {{-4, 0.9, -1}, {4, 0.95, 3}}; }

}  // namespace prehend::perception::testing
