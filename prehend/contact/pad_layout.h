#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "prehend/contact/pad_grid.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::contact {

/// Area of the texel that the constants of a TexelLaw are given for [m^2]: 3.4 mm square, Weiss
/// DSA 9205. A texel of another area has its forces scaled by the ratio, so that a pad's total
/// stiffness does not depend on how finely it is divided.
constexpr double kReferenceTexelArea = 0.0034 * 0.0034;

/// The same pad with each texel divided into factor x factor.
PadGrid refined(const PadGrid& grid, int factor);

/// A surface over the plane z = 0 of P: z [m] at (x, y) [m]; none: it is not there.
using SurfaceHeight = std::function<std::optional<double>(double, double)>;

/// Where the texels of a pad are; does not change. Structure of arrays, each of padded_size()
/// elements: those from size() on repeat no texel (scale 0) and only fill the vectors' last lanes.
/// Pad frame P: for a flat grid x across the columns, y across the rows, z out of the pad.
class PadLayout {
 public:
  /// Arrays are padded to a multiple of this, the most doubles in a vector register.
  static constexpr std::size_t kLanes = 8;

  /// A flat pad centred at P's origin, its face in the plane z = 0. Texels row by row.
  /// @throws std::invalid_argument naming the field that is not positive and finite.
  static PadLayout flat(const PadGrid& grid);

  /// A pad on any triangulated surface (metres, triangles counter-clockwise from outside): a texel
  /// at each vertex that a triangle uses, its normal the mean of the adjacent triangles' normals
  /// (weighted by area), its area a third of theirs; its ray is `thickness` [m] long. Source: the
  /// soft-contact paper. @throws std::invalid_argument for an empty or bad mesh, a vertex whose
  /// triangles face one another (no mean normal), a thickness that is not positive.
  static PadLayout curved(const geometry::TriangleMesh& mesh_P, double thickness);

  /// A grid that is projected along z onto a surface: row by row as flat(), each texel the part of
  /// the surface over its rectangle, its position over the rectangle's middle, its normal the mean
  /// of that part's (weighted by area), its area that part's. Cells of `left_out` (row, column) are
  /// no texels but keep their places, with area 0. @throws std::invalid_argument as flat(); naming
  /// the cell, when the surface does not reach under all of it or falls off steeper than 75
  /// degrees; for a cell left out that the grid does not have, or when all are.
  static PadLayout bent(const PadGrid& grid, const SurfaceHeight& surface,
                        const std::vector<Eigen::Vector2i>& left_out = {});

  /// The texels in another order: texel i of the result is `order`[i] of this one.
  /// @throws std::invalid_argument unless `order` is a permutation.
  PadLayout reordered(const std::vector<std::size_t>& order) const;

  std::size_t size() const { return size_; }
  std::size_t padded_size() const { return x.size(); }
  bool is_flat() const { return flat_; }           // all normals +z, tangents x and y, z = 0
  int rows() const { return rows_; }               // 0 for a mesh's pad
  int columns() const { return columns_; }         // 0 for a mesh's pad
  double thickness() const { return thickness_; }  // m

  Eigen::Vector3d position(std::size_t i) const { return {x[i], y[i], z[i]}; }   // m, on the face
  Eigen::Vector3d normal(std::size_t i) const { return {nx[i], ny[i], nz[i]}; }  // unit, outward
  Eigen::Vector3d first_tangent(std::size_t i) const { return {ux[i], uy[i], uz[i]}; }
  Eigen::Vector3d second_tangent(std::size_t i) const { return {vx[i], vy[i], vz[i]}; }
  double area(std::size_t i) const { return scale[i] * kReferenceTexelArea; }  // m^2
  // Inline, as those above: plug-ins have nothing of prehend linked to them.
  double area() const {  // m^2, of all
    double sum = 0;
    for (const double share : scale) sum += share;
    return sum * kReferenceTexelArea;
  }
  std::size_t cells() const {  // texels that are there: size() but for those left out
    std::size_t count = 0;
    for (const double share : scale) count += share > 0 ? 1 : 0;
    return count;
  }
  /// The surface that the texels are on, in P; null: flat.
  const std::shared_ptr<const geometry::TriangleMesh>& face() const { return face_; }

  // For the kernels. Positions, normals, the two tangents (u, v, n right-handed), area over
  // kReferenceTexelArea.
  std::vector<double> x, y, z, nx, ny, nz, ux, uy, uz, vx, vy, vz, scale;

 private:
  PadLayout() = default;
  void add(const Eigen::Vector3d& position, const Eigen::Vector3d& normal, double area);
  void finish();

  std::size_t size_ = 0;
  bool flat_ = false;
  int rows_ = 0, columns_ = 0;
  double thickness_ = 0;
  std::shared_ptr<const geometry::TriangleMesh> face_;
};

}  // namespace prehend::contact
