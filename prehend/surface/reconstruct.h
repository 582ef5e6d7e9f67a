#pragma once

#include <optional>
#include <span>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/surface/fast_poisson.h"
#include "prehend/surface/pcl_poisson.h"

namespace prehend::surface {

enum class SurfaceMethod {
  kFastPoisson,  // fast_poisson.h
  kPclPoisson,   // pcl_poisson.h, the reference
};

struct SurfaceOptions {
  SurfaceMethod method = SurfaceMethod::kFastPoisson;
  FastPoissonOptions fast_poisson;
  PclPoissonOptions pcl_poisson;
  /// Close the bottom by the footprint on the table: see closing.h.
  bool close_bottom = true;
  /// Height of the lowest slice whose outline is the footprint, as a fraction of the height, (0,
  /// 1].
  double footprint_slice = 0.2;
};

/// The watertight mesh of `cloud`, triangles facing outward, by the chosen method. With a `table`
/// the bottom is closed and no vertex lies below it. Connected parts with less than 5 % of the
/// volume of the largest one are dropped; an object whose neck is thinner than the resolution keeps
/// its head as a second closed part. fast_poisson leaves nothing in space that is known to be
/// `empty` (PCL's, the reference, knows nothing of that). Nothing of the mesh lies under one of the
/// `bounds`.
/// @throws geometry::InputError when the cloud has no normals, has fewer than 30 points or a
/// non-finite one, or when no watertight mesh came out: the message says which defects were left,
/// that the surface is open or that its normals point inward.
/// @throws std::invalid_argument naming an option out of range.
geometry::TriangleMesh reconstruct(const geometry::PointCloud& cloud,
                                   const std::optional<geometry::Plane>& table,
                                   const SurfaceOptions& options = {}, const EmptySpace& empty = {},
                                   std::span<const geometry::Plane> bounds = {});

}  // namespace prehend::surface
