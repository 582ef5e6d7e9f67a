#include "prehend/surface/convex_pieces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/surface/box_parts.h"
#include "prehend/surface/object_frame.h"
#include "prehend/surface/solid_hull.h"
#include "prehend/surface/voxel_solid.h"

namespace prehend::surface {
namespace {

using geometry::InputError;
using geometry::TriangleMesh;
using Polygon = std::vector<Eigen::Vector3d>;

constexpr double kVoxelShare = 0.4;  // of the concavity
constexpr int kLeastVoxels = 16;     // along the longest side
constexpr double kMargin = 1;        // voxels beside the solid
constexpr int kFilledForCorner = 4;  // of the eight voxels at a corner within the solid

void check(const ConvexPiecesOptions& options) {
  const auto require = [](bool condition, const std::string& what) {
    if (!condition) throw std::invalid_argument("ConvexPiecesOptions." + what);
  };
  require(options.concavity > 0 && std::isfinite(options.concavity), "concavity must be > 0");
  require(options.max_voxels >= kLeastVoxels && options.max_voxels <= 128,
          "max_voxels must be in [16, 128]");
  require(options.max_pieces >= 1 && options.max_pieces <= 1000, "max_pieces must be in [1, 1000]");
  require(options.max_hull_vertices >= 8 && options.max_hull_vertices <= 1000,
          "max_hull_vertices must be in [8, 1000]");
}

/// The mesh in voxels, and how to come back.
struct Voxels {
  TriangleMesh mesh;
  Eigen::Vector3i size;
  double side;  // [m]
  geometry::RigidTransform X_MV;
  Eigen::Vector3d to_mesh(const Eigen::Vector3d& p) const { return X_MV * (side * p); }
};

Voxels in_voxels(const TriangleMesh& mesh, const ConvexPiecesOptions& options) {
  const Eigen::Vector3d center = geometry::bounds(mesh).center();
  std::vector<Eigen::Vector3f> about_center;
  for (const Eigen::Vector3d& p : mesh.vertices) {
    about_center.push_back((p - center).cast<float>());
  }
  Voxels voxels;
  voxels.X_MV = object_frame(about_center, std::nullopt);
  voxels.X_MV.translation() += center;
  const geometry::RigidTransform X_VM = voxels.X_MV.inverse(Eigen::Isometry);
  voxels.mesh = mesh;
  Eigen::AlignedBox3d box;
  for (Eigen::Vector3d& p : voxels.mesh.vertices) {
    p = X_VM * p;
    box.extend(p);
  }
  const double extent = box.sizes().maxCoeff();
  if (!(extent > 0)) throw InputError("the mesh has no volume", "give a closed mesh");
  voxels.side = std::clamp(kVoxelShare * options.concavity, extent / options.max_voxels,
                           extent / kLeastVoxels);
  voxels.X_MV.translation() +=
      voxels.X_MV.linear() * (box.min() - Eigen::Vector3d::Constant(kMargin * voxels.side));
  for (Eigen::Vector3d& p : voxels.mesh.vertices) {
    p = (p - box.min()) / voxels.side + Eigen::Vector3d::Constant(kMargin);
  }
  for (int axis = 0; axis < 3; ++axis) {
    voxels.size[axis] =
        static_cast<int>(std::ceil(box.sizes()[axis] / voxels.side + 2 * kMargin)) + 1;
  }
  return voxels;
}

/// The part of a convex polygon with sign * p[axis] <= sign * limit (Sutherland and Hodgman).
void clip(Polygon& polygon, int axis, double limit, double sign) {
  Polygon inside;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d& a = polygon[i];
    const Eigen::Vector3d& b = polygon[(i + 1) % polygon.size()];
    const double of_a = sign * (limit - a[axis]);
    const double of_b = sign * (limit - b[axis]);
    if (of_a >= 0) inside.push_back(a);
    if ((of_a > 0 && of_b < 0) || (of_a < 0 && of_b > 0)) {
      inside.push_back(a + of_a / (of_a - of_b) * (b - a));
    }
  }
  polygon.swap(inside);
}

/// Adds the corners of the mesh's triangles clipped to the box, and those corners of the box that
/// lie in the solid: their hull is that of the solid within the box.
void add_points(const TriangleMesh& mesh, const VoxelSolid& solid, const VoxelBox& box,
                std::vector<Eigen::Vector3d>& points) {
  const Eigen::AlignedBox3d bounds(
      Eigen::Vector3d(box.low.cast<double>() - Eigen::Vector3d::Constant(0.5)),
      Eigen::Vector3d(box.high.cast<double>() + Eigen::Vector3d::Constant(0.5)));
  for (const Eigen::Vector3d& p : mesh.vertices) {
    if (bounds.contains(p)) points.push_back(p);
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    Eigen::AlignedBox3d of_triangle;
    for (const int i : t) of_triangle.extend(mesh.vertices[i]);
    if (!bounds.intersects(of_triangle) || bounds.contains(of_triangle)) continue;
    Polygon polygon{mesh.vertices[t.x()], mesh.vertices[t.y()], mesh.vertices[t.z()]};
    for (int axis = 0; axis < 3 && !polygon.empty(); ++axis) {
      clip(polygon, axis, bounds.min()[axis], -1);
      clip(polygon, axis, bounds.max()[axis], 1);
    }
    points.insert(points.end(), polygon.begin(), polygon.end());
  }
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3i upper;  // the upper of the eight voxels at the corner
    Eigen::Vector3i own;    // the box's
    for (int axis = 0; axis < 3; ++axis) {
      own[axis] = corner >> axis & 1 ? box.high[axis] : box.low[axis];
      upper[axis] = own[axis] + (corner >> axis & 1);
    }
    if (!solid.filled[solid.index(own.x(), own.y(), own.z())]) continue;
    int filled = 0;
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3i voxel = upper - Eigen::Vector3i(k & 1, k >> 1 & 1, k >> 2);
      if ((voxel.array() < 0).any() || (voxel.array() >= solid.size.array()).any()) continue;
      filled += solid.filled[solid.index(voxel.x(), voxel.y(), voxel.z())] ? 1 : 0;
    }
    if (filled < kFilledForCorner) continue;
    points.push_back(upper.cast<double>() - Eigen::Vector3d::Constant(0.5));
  }
}

}  // namespace

ConvexPieces convex_pieces(const TriangleMesh& mesh, const ConvexPiecesOptions& options) {
  check(options);
  check_indices_and_vertices(mesh);
  const Voxels voxels = in_voxels(mesh, options);
  const VoxelSolid solid = voxelized(voxels.mesh, voxels.size);
  // A voxel that is off by one may be half a voxel off the surface; less cannot be told apart.
  const double tolerance = std::max(1.0, options.concavity / voxels.side - 0.5);
  ConvexPieces result;
  for (const BoxPart& part :
       convex_parts(solid, static_cast<float>(tolerance), options.max_pieces)) {
    std::vector<Eigen::Vector3d> points;
    for (const VoxelBox& box : part.boxes) add_points(voxels.mesh, solid, box, points);
    auto hull = solid_hull(points, options.max_hull_vertices);
    if (!hull) continue;
    for (Eigen::Vector3d& vertex : hull->vertices) vertex = voxels.to_mesh(vertex);
    result.pieces.push_back(std::move(*hull));
    result.concavity = std::max(result.concavity, (part.concavity + 0.5) * voxels.side);
  }
  if (result.pieces.empty()) throw InputError("the mesh has no volume", "give a closed mesh");
  return result;
}

}  // namespace prehend::surface
