#pragma once

#include <cstdint>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

struct DelaunayOptions {
  int samples = 500;  // points that are triangulated, >= 3
  /// Triangles with an edge longer than this times the median edge go, > 1, of the lengths in the
  /// image and then of those in space: they bridge what the view has not seen.
  double longest_edge = 5;
  std::uint64_t seed = 1;  // of the choice of the samples
};

/// The baseline of Bohg et al. ("Mind the Gap", ICRA 2011, "Del"): what was seen, without any
/// prediction. Points are drawn uniformly from the finite ones of `cloud_W`, triangulated by
/// Delaunay's criterion in their projection to the image, and triangles with long edges are left
/// out. The largest connected part is closed by triangles spanned between the edges of its contour,
/// as are holes within it, the least area that does; every vertex is a seen point. So the mesh is
/// watertight and faces outward, the front towards the camera. The order of the points does not
/// matter. O(samples log samples + points + contour^3).
/// @throws geometry::InputError with fewer than three points in front of the camera, or when they
/// lie on a line of the image.
/// @throws std::invalid_argument naming an option out of range.
geometry::TriangleMesh delaunay_surface(const geometry::PointCloud& cloud_W,
                                        const geometry::PinholeCamera& camera,
                                        const geometry::RigidTransform& X_WC,
                                        const DelaunayOptions& options = {});

}  // namespace prehend::surface
