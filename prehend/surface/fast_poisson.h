#pragma once

#include <optional>
#include <span>
#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/surface/empty_space.h"

namespace prehend::surface {

/// Knobs of fast_poisson(). `resolution` greatly influences time (its third power) and detail.
struct FastPoissonOptions {
  /// Nodes along the longest side of the grid, whose spacing is scale * extent / resolution. A
  /// multiple of 16, 32..256.
  int resolution = 128;
  /// Nodes are at least this far apart [m], as far as a multiple of 16 from 32 on along the longest
  /// side allows; >= 0.
  double least_spacing = 0;
  double scale = 1.25;  // longest side of the grid over the cloud's extent, in [1.1, 3]
  /// How much the points themselves count besides their normals (α of Kazhdan and Hoppe), >= 0;
  /// large for exact points, small for noisy ones.
  double point_weight = 16;
  int screening_iterations = 3;  // 0..100
  /// Points are spread as wide as this times the mean distance to their neighbours, (0, 4].
  double spread = 1;
  /// Where the inside would reach the grid's border, as that of a bowl seen from above does, close
  /// it by the points' convex hull, widened by one and a half nodes.
  bool close_by_hull = true;
  bool vertex_density = false;  // fill PoissonSurface::density
};

/// A surface with what its points say of it.
struct PoissonSurface {
  geometry::TriangleMesh mesh;
  std::vector<float> density;   // per vertex, if asked for: points per m^2 about it
  bool is_open = false;         // the inside has no end; the mesh is closed by the grid's border
  bool inside_out = false;      // the normals point into what the points enclose
  bool closed_by_hull = false;  // it had none, and is closed by the points' convex hull
};

/// The watertight, manifold mesh whose indicator function's gradient fits the normals of `cloud`
/// best (Kazhdan, Bolitho, Hoppe, "Poisson Surface Reconstruction", SGP 2006) and that passes
/// through its points (screened: Kazhdan and Hoppe 2013), on a dense grid:
/// - Each point stands for an area, the inverse of the points' density about it, and is spread by
///   a quadratic B-spline on the grid, or on one of 2, 4, ... times its spacing where points are
///   sparse.
/// - L u = div V is solved by a fast Fourier transform on the grid, or, where that has more than 80
///   nodes along an axis, on one of half (a quarter) of the nodes; what the periodic continuation
///   takes from an open surface, the mean of V, is given back as a linear function.
/// - The level is the weighted median of u at the points; a few steps of conjugate gradients in a
///   band about them on the full grid pull it there and sharpen it (screening.h).
/// - Marching cubes (marching_cubes.h).
/// Everything is done in a frame of the cloud (z along the `table`'s normal if given, x along the
/// longest extent), in grid units, so a rigid motion of cloud and table moves the mesh, as far as
/// the cloud's single precision and nearly equal extents let it. The order of the points does not
/// matter, not to the last bit. With a `table`, what is under it is outside, and so is what lies in
/// `empty` space or under one of the `bounds`.
/// @throws std::invalid_argument naming an option out of range.
/// @pre cloud has finite points that do not all coincide, and as many finite normals.
PoissonSurface fast_poisson(const geometry::PointCloud& cloud,
                            const std::optional<geometry::Plane>& table,
                            const FastPoissonOptions& options = {}, const EmptySpace& empty = {},
                            std::span<const geometry::Plane> bounds = {});

/// The part of `surface` all of whose triangles' vertices have at least `least_density` points per
/// m^2 about them: what the points say, with holes where they say nothing. Vertices keep their
/// order; those without a triangle go.
/// @throws std::invalid_argument when the surface was made without densities.
geometry::TriangleMesh trimmed(const PoissonSurface& surface, double least_density);

}  // namespace prehend::surface
