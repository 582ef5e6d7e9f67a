#include "eval/touch/imprints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace prehend::eval::touch {
namespace {

constexpr double kCell = 0.001;  // m, of the grid that the cube is made of

}  // namespace

const char* to_string(HoleShape shape) { return shape == HoleShape::kCross ? "cross" : "square"; }

bool in_hole(HoleShape shape, double x, double z) {
  const double a = std::abs(x), b = std::abs(z);
  if (shape == HoleShape::kSquare) return a < 0.006 && b < 0.006;
  return (a < 0.003 && b < 0.009) || (b < 0.003 && a < 0.009);
}

geometry::TriangleMesh perforated_cube(HoleShape shape, double size,
                                       const Eigen::Vector2d& hole_center) {
  const int cells = static_cast<int>(std::lround(size / kCell));
  const double half = 0.5 * size, step = size / cells;
  const auto solid = [&](int i, int k) {
    if (i < 0 || k < 0 || i >= cells || k >= cells) return false;
    return !in_hole(shape, (i + 0.5) * step - half - hole_center.x(),
                    (k + 0.5) * step - half - hole_center.y());
  };
  geometry::TriangleMesh mesh;
  std::map<std::array<int, 3>, int> known;
  const auto vertex = [&](int i, int side, int k) {
    const auto [entry, is_new] =
        known.try_emplace({i, side, k}, static_cast<int>(mesh.vertices.size()));
    if (is_new) mesh.vertices.emplace_back(i * step - half, side * half, k * step - half);
    return entry->second;
  };
  const auto quad = [&](int a, int b, int c, int d) {
    mesh.triangles.emplace_back(a, b, c);
    mesh.triangles.emplace_back(a, c, d);
  };
  for (int i = 0; i < cells; ++i) {
    for (int k = 0; k < cells; ++k) {
      if (!solid(i, k)) continue;
      quad(vertex(i, -1, k), vertex(i + 1, -1, k), vertex(i + 1, -1, k + 1), vertex(i, -1, k + 1));
      quad(vertex(i, 1, k), vertex(i, 1, k + 1), vertex(i + 1, 1, k + 1), vertex(i + 1, 1, k));
      if (!solid(i - 1, k)) {
        quad(vertex(i, -1, k), vertex(i, -1, k + 1), vertex(i, 1, k + 1), vertex(i, 1, k));
      }
      if (!solid(i + 1, k)) {
        quad(vertex(i + 1, -1, k), vertex(i + 1, 1, k), vertex(i + 1, 1, k + 1),
             vertex(i + 1, -1, k + 1));
      }
      if (!solid(i, k - 1)) {
        quad(vertex(i, -1, k), vertex(i, 1, k), vertex(i + 1, 1, k), vertex(i + 1, -1, k));
      }
      if (!solid(i, k + 1)) {
        quad(vertex(i, -1, k + 1), vertex(i + 1, -1, k + 1), vertex(i + 1, 1, k + 1),
             vertex(i, 1, k + 1));
      }
    }
  }
  return mesh;
}

HoleShape recognise(const std::vector<double>& image, int rows, int columns, double pitch,
                    double* agreement) {
  const double most = *std::max_element(image.begin(), image.end());
  double best[2] = {0, 0};
  for (const HoleShape shape : {HoleShape::kCross, HoleShape::kSquare}) {
    for (double x = -0.5 * columns * pitch; x <= 0.5 * columns * pitch; x += 0.25 * pitch) {
      for (double z = -0.5 * rows * pitch; z <= 0.5 * rows * pitch; z += 0.25 * pitch) {
        int both = 0, either = 0;
        for (int t = 0; t < rows * columns; ++t) {
          const bool empty = image[t] < 0.2 * most;
          const bool hole = in_hole(shape, (t % columns + 0.5 - 0.5 * columns) * pitch - x,
                                    (0.5 * rows - t / columns - 0.5) * pitch - z);
          both += empty && hole;
          either += empty || hole;
        }
        const double share = either > 0 ? static_cast<double>(both) / either : 0;
        double& value = best[shape == HoleShape::kCross ? 0 : 1];
        value = std::max(value, share);
      }
    }
  }
  if (agreement) std::copy(best, best + 2, agreement);
  return best[0] >= best[1] ? HoleShape::kCross : HoleShape::kSquare;
}

}  // namespace prehend::eval::touch
