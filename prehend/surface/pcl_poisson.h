#pragma once

#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// Knobs of pcl_poisson(). `depth` greatly influences time and memory: the mesh has a resolution of
/// about scale * extent / 2^depth. Depths 5 and 7 are Mir5 and Mir7 of Bohg et al. (ICRA 2011).
struct PclPoissonOptions {
  int depth = 7;                // of the octree, 3..10
  double samples_per_node = 4;  // 1 keeps all detail, more for noisy clouds; in [1, 20]
  double point_weight = 4;      // how much the points themselves count besides their normals, >= 0
  double scale = 1.25;  // side of the reconstruction cube over the cloud's extent, in [1.05, 3]
};

/// The reference for fast_poisson(): screened Poisson reconstruction on an octree (Kazhdan,
/// Bolitho, Hoppe, "Poisson Surface Reconstruction", SGP 2006) by pcl::Poisson in one thread,
/// bitwise repeatable, in a frame about the cloud so that PCL's single precision does not matter.
/// The mesh may have holes, and PCL prints on standard output where it leaves them.
/// @throws std::invalid_argument naming an option out of range.
/// @pre cloud has finite points that do not all coincide, and as many finite normals.
geometry::TriangleMesh pcl_poisson(const geometry::PointCloud& cloud,
                                   const PclPoissonOptions& options = {});

}  // namespace prehend::surface
