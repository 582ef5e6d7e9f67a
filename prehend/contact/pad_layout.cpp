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

constexpr int kParts = 8;        // of a bent texel's side
constexpr double kSteepest = 4;  // surface over projected area: 75 degrees

std::string cell_text(int row, int column) {
  return "the cell in row " + std::to_string(row) + ", column " + std::to_string(column);
}

void check_grid(const PadGrid& grid) {
  require_positive(grid.rows, "PadGrid::rows");
  require_positive(grid.columns, "PadGrid::columns");
  require_positive(grid.width, "PadGrid::width");
  require_positive(grid.length, "PadGrid::length");
  require_positive(grid.thickness, "PadGrid::thickness");
}

// The part of a surface over a cell, whose lowest corner is `corner`: kParts by kParts rectangles
// of two triangles.
geometry::TriangleMesh part_of(const SurfaceHeight& surface, const Eigen::Vector2d& corner,
                               const Eigen::Vector2d& size, const std::string& cell) {
  geometry::TriangleMesh part;
  for (int j = 0; j <= kParts; ++j) {
    for (int i = 0; i <= kParts; ++i) {
      const double x = corner.x() + i * size.x() / kParts, y = corner.y() + j * size.y() / kParts;
      const std::optional<double> z = surface(x, y);
      if (!z) {
        throw std::invalid_argument("PadLayout::bent: " + cell + " lies beside the surface");
      }
      part.vertices.emplace_back(x, y, *z);
    }
  }
  for (int j = 0; j < kParts; ++j) {
    for (int i = 0; i < kParts; ++i) {
      const int a = j * (kParts + 1) + i, b = a + 1, c = a + kParts + 1, d = c + 1;
      part.triangles.emplace_back(a, b, d);
      part.triangles.emplace_back(a, d, c);
    }
  }
  return part;
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
  check_grid(grid);
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

PadLayout PadLayout::bent(const PadGrid& grid, const SurfaceHeight& surface,
                          const std::vector<Eigen::Vector2i>& left_out) {
  check_grid(grid);
  for (const Eigen::Vector2i& cell : left_out) {
    if (cell.minCoeff() < 0 || cell.x() >= grid.rows || cell.y() >= grid.columns) {
      throw std::invalid_argument("PadLayout::bent: " + cell_text(cell.x(), cell.y()) +
                                  " cannot be left out, as the grid does not have it");
    }
  }
  PadLayout pad;
  pad.rows_ = grid.rows;
  pad.columns_ = grid.columns;
  pad.thickness_ = grid.thickness;
  std::vector<geometry::TriangleMesh> parts;
  const Eigen::Vector2d size(grid.width / grid.columns, grid.length / grid.rows);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const Eigen::Vector2d corner(column * size.x() - 0.5 * grid.width,
                                   0.5 * grid.length - (row + 1) * size.y());
      const Eigen::Vector2d middle = corner + 0.5 * size;
      if (std::count(left_out.begin(), left_out.end(), Eigen::Vector2i(row, column)) > 0) {
        pad.add({middle.x(), middle.y(), 0}, Eigen::Vector3d::UnitZ(), 0);
        continue;
      }
      geometry::TriangleMesh part = part_of(surface, corner, size, cell_text(row, column));
      Eigen::Vector3d twice_area = Eigen::Vector3d::Zero();
      for (const Eigen::Vector3i& t : part.triangles) {
        twice_area += (part.vertices[t[1]] - part.vertices[t[0]])
                          .cross(part.vertices[t[2]] - part.vertices[t[0]]);
      }
      const double area = geometry::surface_area(part);
      if (area > kSteepest * size.prod()) {
        throw std::invalid_argument("PadLayout::bent: the surface falls off too steeply under " +
                                    cell_text(row, column));
      }
      pad.add(part.vertices[(kParts + 1) * (kParts / 2) + kParts / 2], twice_area.normalized(),
              area);
      parts.push_back(std::move(part));
    }
  }
  if (parts.empty()) throw std::invalid_argument("PadLayout::bent: all cells are left out");
  pad.face_ = std::make_shared<const geometry::TriangleMesh>(geometry::concatenated(parts));
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
  pad.face_ = std::make_shared<const geometry::TriangleMesh>(mesh_P);
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
