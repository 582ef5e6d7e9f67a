#include "prehend/surface/splat.h"

#include <algorithm>

namespace prehend::surface {
namespace {

/// Quadratic B-spline of width 3 at distance `d` of at most 0.5, then at the two beside it.
Eigen::Array3f spline(float d) {
  return {0.5f * (0.5f - d) * (0.5f - d), 0.75f - d * d, 0.5f * (0.5f + d) * (0.5f + d)};
}

}  // namespace

SplineWindow::SplineWindow(float x) {
  const int lower = static_cast<int>(x);
  const float f = x - static_cast<float>(lower);
  first = lower - 1;
  const Eigen::Array3f on_nodes = spline(f < 0.5f ? f : f - 1);
  smooth.setZero();
  if (f < 0.5f) {
    smooth.head<3>() = on_nodes;
  } else {
    smooth.tail<3>() = on_nodes;
  }
  const Eigen::Array3f between = spline(f - 0.5f);
  slope << between[0], between[1] - between[0], between[2] - between[1], -between[2];
}

void splat(ScalarGrid& grid, const Eigen::Vector3f& p, float amount) {
  const SplineWindow x(p.x());
  const SplineWindow y(p.y());
  const SplineWindow z(p.z());
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 4; ++j) {
      Eigen::Map<Eigen::Array4f> row(&grid.at(x.first, y.first + j, z.first + k));
      row += amount * y.smooth[j] * z.smooth[k] * x.smooth;
    }
  }
}

float gather(const ScalarGrid& grid, const Eigen::Vector3f& p) {
  const SplineWindow x(p.x());
  const SplineWindow y(p.y());
  const SplineWindow z(p.z());
  Eigen::Array4f sum = Eigen::Array4f::Zero();
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 4; ++j) {
      const Eigen::Map<const Eigen::Array4f> row(grid.data() +
                                                 grid.index(x.first, y.first + j, z.first + k));
      sum += y.smooth[j] * z.smooth[k] * row;
    }
  }
  return (sum * x.smooth).sum();
}

void splat_divergence(ScalarGrid& grid, const Eigen::Vector3f& p, const Eigen::Vector3f& v) {
  const SplineWindow x(p.x());
  const SplineWindow y(p.y());
  const SplineWindow z(p.z());
  const Eigen::Array4f along_x = v.x() * x.slope;
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 4; ++j) {
      Eigen::Map<Eigen::Array4f> row(&grid.at(x.first, y.first + j, z.first + k));
      row += y.smooth[j] * z.smooth[k] * along_x +
             (v.y() * y.slope[j] * z.smooth[k] + v.z() * y.smooth[j] * z.slope[k]) * x.smooth;
    }
  }
}

void add_upsampled(const ScalarGrid& coarse, ScalarGrid& fine) {
  const Eigen::Vector3i& n = coarse.size();
  std::vector<float> row(n.x());
  for (int z = 0; z < fine.size().z(); ++z) {
    // The nearer coarse node counts 3/4, the other 1/4.
    const int z0 = z / 2;
    const int z1 = std::clamp(z0 + (z % 2 == 0 ? -1 : 1), 0, n.z() - 1);
    for (int y = 0; y < fine.size().y(); ++y) {
      const int y0 = y / 2;
      const int y1 = std::clamp(y0 + (y % 2 == 0 ? -1 : 1), 0, n.y() - 1);
      const float* a = coarse.data() + coarse.index(0, y0, z0);
      const float* b = coarse.data() + coarse.index(0, y1, z0);
      const float* c = coarse.data() + coarse.index(0, y0, z1);
      const float* d = coarse.data() + coarse.index(0, y1, z1);
      for (int x = 0; x < n.x(); ++x) {
        row[x] = 0.5625f * a[x] + 0.1875f * (b[x] + c[x]) + 0.0625f * d[x];
      }
      float* out = &fine.at(0, y, z);
      for (int x = 0; x < n.x(); ++x) {
        out[2 * x] += 0.75f * row[x] + 0.25f * row[std::max(0, x - 1)];
        out[2 * x + 1] += 0.75f * row[x] + 0.25f * row[std::min(n.x() - 1, x + 1)];
      }
    }
  }
}

}  // namespace prehend::surface
