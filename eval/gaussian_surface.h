#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/belief/evidence.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/swept_space.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::eval {

struct GaussianSurfaceOptions {
  int seen_points = 300;    // of the seen ones, spread evenly
  int empty_points = 100;   // of swept space
  double offset = 0.02;     // m, along a normal, of the points that are known to be out- and inside
  int resolution = 64;      // nodes along the longest side
  double deviation = 0.01;  // of the function at the points, standard
};

/// The classical baseline for shapes from seeing and touching: a Gaussian process implicit surface
/// (O. Williams and A. Fitzgibbon, "Gaussian Process Implicit Surfaces", GPC 2007; for grasping S.
/// Dragiev, M. Toussaint, M. Gienger, "Gaussian Process Implicit Surfaces for Shape Estimation and
/// Grasping", ICRA 2011). The function is 0 on the surface, 1 outside and -1 inside; the covariance
/// is their thin plate's, k(r) = 2 r^3 - 3 R r^2 + R^3, R the longest distance. Knows what was seen
/// (with normals), the contacts (with theirs), points in swept space and points under the support,
/// all outside; no symmetry. The surface is that of its mean, over
/// the table.
geometry::TriangleMesh gaussian_surface(const geometry::PointCloud& seen_W,
                                        const std::vector<belief::Contact>& contacts,
                                        const geometry::SweptSpace& swept,
                                        const geometry::Plane& table_W,
                                        const Eigen::AlignedBox3d& box_W,
                                        const GaussianSurfaceOptions& options = {});

}  // namespace prehend::eval
