#pragma once

#include <optional>
#include <string>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// Knobs of the reconstruction. `depth` greatly influences time and memory: the mesh has a
/// resolution of about scale * extent / 2^depth.
struct PoissonOptions {
  int depth = 7;             // of the octree, 3..10
  double samples_per_node = 1.5;  // raise it for noisy clouds, in [1, 20]
  double point_weight = 4;   // how much the points themselves count besides their normals, >= 0
  double scale = 1.25;       // side of the reconstruction cube over the cloud's extent, in [1.05, 3]
  /// Close the bottom by the footprint on the table: see close_bottom().
  bool close_bottom = true;
  /// Height of the lowest slice whose outline is the footprint, as a fraction of the height, (0, 1].
  double footprint_slice = 0.2;
};

/// `cloud` (with normals) and, on the table, the unseen bottom: the convex outline of the lowest
/// `slice` (fraction of the height over the table) filled with points at `spacing` [m] on the table
/// with normals -table.normal, and the gap between that slice and the table with points of the
/// outline whose normals point outwards. An object stands on its table, so its bottom is there;
/// without these points Poisson's surface bulges below the table.
/// @throws geometry::InputError when the cloud has no normals or does not rise above the table.
geometry::PointCloud close_bottom(const geometry::PointCloud& cloud, const geometry::Plane& table,
                                  double slice, double spacing);

/// The surface whose indicator function's gradient fits the points' normals best: screened Poisson
/// (Kazhdan, Bolitho, Hoppe: "Poisson Surface Reconstruction", SGP 2006) by pcl::Poisson in one
/// thread, bitwise repeatable. With a `table` the bottom is closed and no vertex lies below it.
/// Only the largest connected part is kept. The mesh is watertight and its triangles face outward.
/// @throws geometry::InputError when the cloud has no normals, has fewer than 30 points or a
/// non-finite one, or when no watertight mesh came out at any tried depth (it is lowered twice,
/// with a larger cube); the message says which defects were left.
geometry::TriangleMesh reconstruct(const geometry::PointCloud& cloud,
                                   const std::optional<geometry::Plane>& table,
                                   const PoissonOptions& options = {});

}  // namespace prehend::surface
