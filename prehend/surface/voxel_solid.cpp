#include "prehend/surface/voxel_solid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace prehend::surface {
namespace {

// Off the lattice, so that rows along x meet corners and edges of boxes in no special place.
constexpr double kRowShiftY = 1.7e-4;
constexpr double kRowShiftZ = 2.9e-4;

/// Twice the signed area of (a, b, p) in the y-z plane; exactly the negative with a and b swapped,
/// and never zero, so that a row crosses exactly one of two triangles at their common edge.
double side(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double y, double z) {
  const bool swap = std::pair(a.y(), a.z()) > std::pair(b.y(), b.z());
  const Eigen::Vector3d& p = swap ? b : a;
  const Eigen::Vector3d& q = swap ? a : b;
  double area = (q.y() - p.y()) * (z - p.z()) - (q.z() - p.z()) * (y - p.y());
  if (area == 0) area = std::numeric_limits<double>::min();
  return swap ? -area : area;
}

struct Crossing {
  float x;
  int winding;  // +1 where the row enters
};

void fill_inside(const geometry::TriangleMesh& mesh, VoxelSolid& solid) {
  std::vector<std::vector<Crossing>> rows(static_cast<std::size_t>(solid.size.y()) *
                                          solid.size.z());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[t.x()];
    const Eigen::Vector3d& b = mesh.vertices[t.y()];
    const Eigen::Vector3d& c = mesh.vertices[t.z()];
    const auto first = [](double p, double q, double r, double shift) {
      return std::max(0, static_cast<int>(std::ceil(std::min({p, q, r}) - shift)));
    };
    const auto last = [](double p, double q, double r, double shift, int size) {
      return std::min(size - 1, static_cast<int>(std::floor(std::max({p, q, r}) - shift)));
    };
    const int last_z = last(a.z(), b.z(), c.z(), kRowShiftZ, solid.size.z());
    const int last_y = last(a.y(), b.y(), c.y(), kRowShiftY, solid.size.y());
    for (int k = first(a.z(), b.z(), c.z(), kRowShiftZ); k <= last_z; ++k) {
      for (int j = first(a.y(), b.y(), c.y(), kRowShiftY); j <= last_y; ++j) {
        const double y = j + kRowShiftY;
        const double z = k + kRowShiftZ;
        const double of_c = side(a, b, y, z);
        const double of_a = side(b, c, y, z);
        const double of_b = side(c, a, y, z);
        if ((of_a > 0) != (of_b > 0) || (of_b > 0) != (of_c > 0)) continue;
        const double x = (of_a * a.x() + of_b * b.x() + of_c * c.x()) / (of_a + of_b + of_c);
        // A normal with positive x, counter-clockwise in y-z, is where the row leaves.
        rows[static_cast<std::size_t>(k) * solid.size.y() + j].push_back(
            {static_cast<float>(x), of_a > 0 ? -1 : 1});
      }
    }
  }
  for (std::size_t row = 0; row < rows.size(); ++row) {
    auto& crossings = rows[row];
    std::sort(crossings.begin(), crossings.end(),
              [](const Crossing& p, const Crossing& q) { return p.x < q.x; });
    int winding = 0;
    for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
      winding += crossings[i].winding;
      if (winding <= 0) continue;
      const int end =
          std::min(solid.size.x() - 1, static_cast<int>(std::floor(crossings[i + 1].x)));
      for (int x = std::max(0, static_cast<int>(std::ceil(crossings[i].x))); x <= end; ++x) {
        solid.filled[row * solid.size.x() + x] = true;
      }
    }
  }
}

/// The voxels of points spread over each triangle at most half a voxel apart.
void fill_surface(const geometry::TriangleMesh& mesh, VoxelSolid& solid) {
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[t.x()];
    const Eigen::Vector3d ab = mesh.vertices[t.y()] - a;
    const Eigen::Vector3d ac = mesh.vertices[t.z()] - a;
    const double longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
    const int steps = std::max(1, static_cast<int>(std::ceil(2 * longest)));
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; i + j <= steps; ++j) {
        const Eigen::Vector3d p = a + (i * ab + j * ac) / steps;
        const Eigen::Vector3i voxel = (p.array() + 0.5).floor().cast<int>().matrix();
        const Eigen::Vector3i inner =
            voxel.cwiseMax(0).cwiseMin(solid.size - Eigen::Vector3i::Ones());
        solid.filled[solid.index(inner.x(), inner.y(), inner.z())] = true;
      }
    }
  }
}

/// Lower envelope of the parabolas of `values` [n], written back.
void transform_line(std::vector<float>& values, std::vector<int>& parabola,
                    std::vector<float>& from, std::vector<float>& result) {
  const int n = static_cast<int>(values.size());
  int last = -1;
  for (int q = 0; q < n; ++q) {
    if (values[q] == std::numeric_limits<float>::infinity()) continue;
    float start = -std::numeric_limits<float>::infinity();
    while (last >= 0) {
      const int p = parabola[last];
      start = (values[q] + static_cast<float>(q * q) - values[p] - static_cast<float>(p * p)) /
              static_cast<float>(2 * (q - p));
      if (start > from[last]) break;
      --last;
    }
    if (last < 0) start = -std::numeric_limits<float>::infinity();
    ++last;
    parabola[last] = q;
    from[last] = start;
  }
  if (last < 0) return;
  int at = 0;
  for (int q = 0; q < n; ++q) {
    while (at < last && from[at + 1] < static_cast<float>(q)) ++at;
    const auto d = static_cast<float>(q - parabola[at]);
    result[q] = d * d + values[parabola[at]];
  }
  values.swap(result);
}

void measure_distances(VoxelSolid& solid) {
  solid.distance.resize(solid.filled.size());
  for (std::size_t i = 0; i < solid.filled.size(); ++i) {
    solid.distance[i] = solid.filled[i] ? 0 : std::numeric_limits<float>::infinity();
  }
  const Eigen::Vector3i& n = solid.size;
  const std::size_t stride[3] = {1, static_cast<std::size_t>(n.x()),
                                 static_cast<std::size_t>(n.x()) * n.y()};
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    std::vector<float> values(n[axis]);
    std::vector<float> result(n[axis]);
    std::vector<int> parabola(n[axis]);
    std::vector<float> from(n[axis]);
    for (int i = 0; i < n[u]; ++i) {
      for (int j = 0; j < n[v]; ++j) {
        float* line = solid.distance.data() + i * stride[u] + j * stride[v];
        for (int k = 0; k < n[axis]; ++k) values[k] = line[k * stride[axis]];
        transform_line(values, parabola, from, result);
        for (int k = 0; k < n[axis]; ++k) line[k * stride[axis]] = values[k];
      }
    }
  }
  for (float& d : solid.distance) d = std::sqrt(d);
}

}  // namespace

VoxelSolid voxelized(const geometry::TriangleMesh& mesh, const Eigen::Vector3i& size) {
  VoxelSolid solid;
  solid.size = size;
  solid.filled.assign(static_cast<std::size_t>(size.x()) * size.y() * size.z(), false);
  fill_inside(mesh, solid);
  fill_surface(mesh, solid);
  measure_distances(solid);
  return solid;
}

}  // namespace prehend::surface
