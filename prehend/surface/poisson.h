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
  int depth = 7;                // of the octree, 3..10
  double samples_per_node = 4;  // 1 keeps all detail, more for noisy clouds; in [1, 20]
  double point_weight = 4;      // how much the points themselves count besides their normals, >= 0
  double scale = 1.25;  // side of the reconstruction cube over the cloud's extent, in [1.05, 3]
  /// Close the bottom by the footprint on the table: see closing.h.
  bool close_bottom = true;
  /// Height of the lowest slice whose outline is the footprint, as a fraction of the height, (0,
  /// 1].
  double footprint_slice = 0.2;
};

/// The surface whose indicator function's gradient fits the points' normals best: screened Poisson
/// (Kazhdan, Bolitho, Hoppe: "Poisson Surface Reconstruction", SGP 2006) by pcl::Poisson in one
/// thread, bitwise repeatable. With a `table` the bottom is closed and no vertex lies below it.
/// Connected parts with less than 5 % of the largest one's triangles are dropped; an object whose
/// neck is thinner than the resolution keeps its head as a second closed part. The mesh is
/// watertight and its triangles face outward. When neither `depth` with two cubes nor the two
/// depths below it give a mesh without holes, the holes of the one with the smallest are closed by
/// fans (see holes.h), if they are less than 5 % of its surface.
/// @throws geometry::InputError when the cloud has no normals, has fewer than 30 points or a
/// non-finite one, or when no watertight mesh came out. The message says which defects were left.
geometry::TriangleMesh reconstruct(const geometry::PointCloud& cloud,
                                   const std::optional<geometry::Plane>& table,
                                   const PoissonOptions& options = {});

}  // namespace prehend::surface
