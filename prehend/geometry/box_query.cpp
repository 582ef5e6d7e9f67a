#include "prehend/geometry/box_query.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "prehend/geometry/mesh_query.h"

namespace prehend::geometry {
namespace {

using Eigen::Vector3d;

constexpr double kCell = 0.02;     // m
constexpr double kMostCells = 16;  // along a side

}  // namespace

bool does_triangle_meet_box(const Vector3d& a, const Vector3d& b, const Vector3d& c,
                            const Vector3d& half_size) {
  if (((a.cwiseMin(b).cwiseMin(c) - half_size).array() > 0).any() ||
      ((a.cwiseMax(b).cwiseMax(c) + half_size).array() < 0).any()) {
    return false;
  }
  const Vector3d ab = b - a, bc = c - b;
  const Vector3d normal = ab.cross(bc);
  if (std::abs(normal.dot(a)) > normal.cwiseAbs().dot(half_size)) return false;
  const Vector3d ca = a - c;
  for (const Vector3d* side : {&ab, &bc, &ca}) {
    for (int k = 0; k < 3; ++k) {
      const Vector3d axis = Vector3d::Unit(k).cross(*side);
      const double of_a = axis.dot(a), of_b = axis.dot(b), of_c = axis.dot(c);
      const double most = axis.cwiseAbs().dot(half_size);
      if (std::min({of_a, of_b, of_c}) > most || std::max({of_a, of_b, of_c}) < -most) {
        return false;
      }
    }
  }
  return true;
}

bool does_surface_meet_box(const SurfaceQuery& surface_W, const RigidTransform& X_WB,
                           const Vector3d& half_size) {
  if (!half_size.allFinite() || half_size.minCoeff() < 0) {
    throw std::invalid_argument("does_surface_meet_box: half_size must be finite and >= 0");
  }
  const Vector3d reach = X_WB.linear().cwiseAbs() * half_size;
  const Eigen::AlignedBox3d& all = surface_W.box();
  if (!all.intersects({X_WB.translation() - reach, X_WB.translation() + reach})) return false;
  const TriangleMesh& mesh = surface_W.mesh();
  const RigidTransform X_BW = X_WB.inverse();
  const Eigen::Vector3i cells =
      (2 * half_size / std::max(kCell, 2 * half_size.maxCoeff() / kMostCells))
          .array()
          .ceil()
          .max(1.0)
          .cast<int>();
  const Vector3d cell = 2 * half_size.cwiseQuotient(cells.cast<double>());
  const double radius = cell.norm() / 2;
  const Vector3d cell_reach = X_WB.linear().cwiseAbs() * cell / 2;
  thread_local std::vector<int> near;
  for (int z = 0; z < cells.z(); ++z) {
    for (int y = 0; y < cells.y(); ++y) {
      for (int x = 0; x < cells.x(); ++x) {
        const Vector3d middle_W =
            X_WB * (Vector3d(x + 0.5, y + 0.5, z + 0.5).cwiseProduct(cell) - half_size);
        if (!all.intersects({middle_W - cell_reach, middle_W + cell_reach})) continue;
        surface_W.near_triangles(middle_W, radius, &near);
        for (const int i : near) {
          const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(i)];
          const auto corner = [&](int k) {
            return Vector3d(X_BW * mesh.vertices[static_cast<std::size_t>(t[k])]);
          };
          if (does_triangle_meet_box(corner(0), corner(1), corner(2), half_size)) return true;
        }
      }
    }
  }
  return false;
}

}  // namespace prehend::geometry
