#include "prehend/surface/marching_cubes.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "prehend/surface/marching_cubes_cases.h"

namespace prehend::surface {
namespace {

// How near a vertex may come to a node, as a fraction of the grid's spacing.
constexpr double kLeastFraction = 1e-3;

/// Where between a (0) and b (1) the field passes `level`; the middle when that is no number.
double crossing(float a, float b, float level) {
  const double t = (static_cast<double>(level) - a) / (static_cast<double>(b) - a);
  return t == t ? std::clamp(t, kLeastFraction, 1 - kLeastFraction) : 0.5;
}

/// Works slab by slab, so that only the vertices of two layers of nodes have to be remembered.
class Extraction {
 public:
  Extraction(const ScalarGrid& field, float level) : field_(field), level_(level) {
    for (int layer = 0; layer < 2; ++layer) {
      inside_[layer].resize(field.slab());
      for (int axis = 0; axis < 3; ++axis) edges_[layer][axis].assign(field.slab(), -1);
    }
  }

  geometry::TriangleMesh run() {
    classify(0);
    for (int z = 0; z + 1 < field_.size().z(); ++z) {
      if (z + 1 < field_.size().z()) classify(z + 1);
      for (int y = 0; y + 1 < field_.size().y(); ++y) row(y, z);
    }
    return std::move(mesh_);
  }

 private:
  void classify(int z) {
    const Eigen::Vector3i& n = field_.size();
    std::uint8_t* inside = inside_[z % 2].data();
    for (int* edge : used_[z % 2]) *edge = -1;
    used_[z % 2].clear();
    if (z == 0 || z == n.z() - 1) {
      std::fill_n(inside, field_.slab(), 0);
      return;
    }
    const float* values = field_.data() + field_.index(0, 0, z);
    const float level = level_;
    for (std::ptrdiff_t i = 0; i < field_.slab(); ++i) inside[i] = values[i] > level ? 1 : 0;
    std::fill_n(inside, field_.pitch(), 0);
    std::fill_n(inside + static_cast<std::ptrdiff_t>(n.y() - 1) * field_.pitch(), field_.pitch(),
                0);
    for (int y = 1; y + 1 < n.y(); ++y) {
      std::uint8_t* of_row = inside + static_cast<std::ptrdiff_t>(y) * field_.pitch();
      of_row[0] = 0;
      std::fill(of_row + n.x() - 1, of_row + field_.pitch(), 0);
    }
  }

  /// All cubes between rows y, y + 1 and layers z, z + 1.
  void row(int y, int z) {
    const int pitch = field_.pitch();
    const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(y) * pitch;
    const std::uint8_t* a = inside_[z % 2].data() + start;
    const std::uint8_t* b = a + pitch;
    const std::uint8_t* c = inside_[(z + 1) % 2].data() + start;
    const std::uint8_t* d = c + pitch;
    columns_.resize(pitch + 8);
    for (int x = 0; x < pitch; ++x) {
      columns_[x] = static_cast<std::uint8_t>(a[x] | b[x] << 2 | c[x] << 4 | d[x] << 6);
    }
    for (int x = 0; x + 1 < field_.size().x();) {
      // Eight cubes at once where nothing changes.
      std::uint64_t here = 0;
      std::uint64_t next = 0;
      std::memcpy(&here, &columns_[x], 8);
      std::memcpy(&next, &columns_[x + 1], 8);
      if (x + 9 <= pitch && here == next && (here == 0 || here == 0x5555555555555555ULL)) {
        x += 8;
        continue;
      }
      const int inside = columns_[x] | columns_[x + 1] << 1;
      if (inside != 0 && inside != 255) cube(x, y, z, inside);
      ++x;
    }
  }

  void cube(int x, int y, int z, int inside) {
    static const std::array<CubeCase, 256>& cases = cube_cases();
    const CubeCase& rule = cases[inside];
    std::array<int, 16> vertex;
    vertex.fill(-1);
    for (std::size_t i = 0; i < rule.centered.size(); ++i) {
      Eigen::Vector3d center = Eigen::Vector3d::Zero();
      for (const int e : rule.centered[i]) {
        center +=
            mesh_.vertices[vertex_on(x, y, z, e)] / static_cast<double>(rule.centered[i].size());
      }
      vertex[12 + i] = static_cast<int>(mesh_.vertices.size());
      mesh_.vertices.push_back(center);
    }
    for (const auto& t : rule.triangles) {
      Eigen::Vector3i triangle;
      for (int k = 0; k < 3; ++k) {
        int& index = vertex[t[k]];
        if (index < 0) index = vertex_on(x, y, z, t[k]);
        triangle[k] = index;
      }
      mesh_.triangles.push_back(triangle);
    }
  }

  /// The vertex on edge `e` of the cube at (x, y, z), made when it is new.
  int vertex_on(int x, int y, int z, int e) {
    const int corner = edge_corner(e);
    const int axis = e / 4;
    x += corner & 1;
    y += corner >> 1 & 1;
    z += corner >> 2;
    int& index = edges_[z % 2][axis][static_cast<std::ptrdiff_t>(y) * field_.pitch() + x];
    if (index < 0) {
      index = static_cast<int>(mesh_.vertices.size());
      used_[z % 2].push_back(&index);
      const Eigen::Vector3i step = Eigen::Vector3i::Unit(axis);
      Eigen::Vector3d p(x, y, z);
      p[axis] += crossing(value(x, y, z), value(x + step.x(), y + step.y(), z + step.z()), level_);
      mesh_.vertices.push_back(p);
    }
    return index;
  }

  /// The field, lowered to the level on the border, where everything is outside.
  float value(int x, int y, int z) const {
    const Eigen::Vector3i& n = field_.size();
    const bool border =
        x == 0 || y == 0 || z == 0 || x == n.x() - 1 || y == n.y() - 1 || z == n.z() - 1;
    const float raw = field_.at(x, y, z);
    return border ? std::min(raw, level_) : raw;
  }

  const ScalarGrid& field_;
  float level_;
  geometry::TriangleMesh mesh_;
  std::array<std::vector<std::uint8_t>, 2> inside_;       // of layers z % 2
  std::array<std::array<std::vector<int>, 3>, 2> edges_;  // vertex on the edge from a node, or -1
  std::array<std::vector<int*>, 2> used_;                 // those that have one
  std::vector<std::uint8_t> columns_;
};

}  // namespace

geometry::TriangleMesh marching_cubes(const ScalarGrid& field, float level) {
  if (field.size().minCoeff() < 2) return {};
  return Extraction(field, level).run();
}

}  // namespace prehend::surface
