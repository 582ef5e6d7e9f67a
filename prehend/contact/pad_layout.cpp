#include "prehend/contact/pad_layout.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "prehend/contact/require.h"

namespace prehend::contact {
namespace {

// All arrays of the layout, for what is done to each alike.
template <class Layout>
auto arrays(Layout& pad) {
  return std::vector{&pad.x,  &pad.y,  &pad.z,  &pad.nx, &pad.ny, &pad.nz,   &pad.ux,
                     &pad.uy, &pad.uz, &pad.vx, &pad.vy, &pad.vz, &pad.scale};
}

}  // namespace

PadGrid refined(const PadGrid& grid, int factor) {
  if (factor < 1) throw std::invalid_argument("refined: factor must be 1 or more");
  PadGrid fine = grid;
  fine.rows *= factor;
  fine.columns *= factor;
  return fine;
}

void PadLayout::add(const Eigen::Vector3d& position, const Eigen::Vector3d& normal, double area) {
  // The tangent nearest to x, or to y where the normal is along x.
  Eigen::Vector3d first = Eigen::Vector3d::UnitX() - normal.x() * normal;
  if (first.norm() < 0.1) first = Eigen::Vector3d::UnitY() - normal.y() * normal;
  first.normalize();
  const Eigen::Vector3d second = normal.cross(first);
  const auto put = [](const Eigen::Vector3d& p, auto& a, auto& b, auto& c) {
    a.push_back(p.x());
    b.push_back(p.y());
    c.push_back(p.z());
  };
  put(position, x, y, z);
  put(normal, nx, ny, nz);
  put(first, ux, uy, uz);
  put(second, vx, vy, vz);
  scale.push_back(area / kReferenceTexelArea);
}

void PadLayout::finish() {
  size_ = x.size();
  const std::size_t padded = (size_ + kLanes - 1) / kLanes * kLanes;
  for (auto* array : arrays(*this)) array->resize(padded, array->back());
  std::fill(scale.begin() + static_cast<std::ptrdiff_t>(size_), scale.end(), 0.0);
}

PadLayout PadLayout::flat(const PadGrid& grid) {
  require_positive(grid.rows, "PadGrid::rows");
  require_positive(grid.columns, "PadGrid::columns");
  require_positive(grid.width, "PadGrid::width");
  require_positive(grid.length, "PadGrid::length");
  require_positive(grid.thickness, "PadGrid::thickness");
  PadLayout pad;
  pad.flat_ = true;
  pad.rows_ = grid.rows;
  pad.columns_ = grid.columns;
  pad.thickness_ = grid.thickness;
  const double pitch_x = grid.width / grid.columns, pitch_y = grid.length / grid.rows;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      pad.add({(column + 0.5) * pitch_x - 0.5 * grid.width,
               0.5 * grid.length - (row + 0.5) * pitch_y, 0},
              Eigen::Vector3d::UnitZ(), pitch_x * pitch_y);
    }
  }
  pad.finish();
  return pad;
}

PadLayout PadLayout::curved(const geometry::TriangleMesh& mesh_P, double thickness) {
  require_positive(thickness, "PadLayout::curved: thickness");
  if (mesh_P.empty()) throw std::invalid_argument("PadLayout::curved: the mesh has no triangles");
  const std::size_t count = mesh_P.vertices.size();
  std::vector<Eigen::Vector3d> twice_area(count, Eigen::Vector3d::Zero());
  std::vector<double> area(count, 0.0);
  for (const Eigen::Vector3i& t : mesh_P.triangles) {
    for (int k = 0; k < 3; ++k) {
      if (t[k] < 0 || static_cast<std::size_t>(t[k]) >= count) {
        throw std::invalid_argument("PadLayout::curved: a triangle names vertex " +
                                    std::to_string(t[k]) + ", which is not there");
      }
    }
    const Eigen::Vector3d normal = (mesh_P.vertices[t[1]] - mesh_P.vertices[t[0]])
                                       .cross(mesh_P.vertices[t[2]] - mesh_P.vertices[t[0]]);
    for (int k = 0; k < 3; ++k) {
      twice_area[t[k]] += normal;
      area[t[k]] += normal.norm() / 6;
    }
  }
  PadLayout pad;
  pad.thickness_ = thickness;
  for (std::size_t i = 0; i < count; ++i) {
    if (area[i] == 0) continue;
    if (!mesh_P.vertices[i].allFinite() || !(twice_area[i].norm() > 1e-6 * area[i])) {
      throw std::invalid_argument("PadLayout::curved: vertex " + std::to_string(i) +
                                  " is not finite or its triangles have no mean normal");
    }
    pad.add(mesh_P.vertices[i], twice_area[i].normalized(), area[i]);
  }
  if (pad.x.empty()) {
    throw std::invalid_argument("PadLayout::curved: the mesh's triangles have no area");
  }
  pad.finish();
  return pad;
}

PadLayout PadLayout::reordered(const std::vector<std::size_t>& order) const {
  std::vector<bool> seen(size_, false);
  bool is_permutation = order.size() == size_;
  for (const std::size_t i : order) {
    is_permutation = is_permutation && i < size_ && !seen[i];
    if (is_permutation) seen[i] = true;
  }
  if (!is_permutation) {
    throw std::invalid_argument("PadLayout::reordered: order must name each texel once");
  }
  PadLayout pad = *this;
  const auto from = arrays(*this);
  const auto to = arrays(pad);
  for (std::size_t a = 0; a < from.size(); ++a) {
    for (std::size_t i = 0; i < size_; ++i) (*to[a])[i] = (*from[a])[order[i]];
  }
  return pad;
}

}  // namespace prehend::contact
