#include "prehend/surface/screening.h"

#include <algorithm>
#include <cstddef>

#include "prehend/surface/band.h"

namespace prehend::surface {
namespace {

/// The linear weights of the eight nodes of the cell about a point.
struct CellWeights {
  explicit CellWeights(const Eigen::Vector3f& p) {
    const Eigen::Vector3i cell = p.cast<int>();
    const Eigen::Vector3f f = p - cell.cast<float>();
    for (int k = 0; k < 4; ++k) {
      const float yz = (k & 1 ? f.y() : 1 - f.y()) * (k & 2 ? f.z() : 1 - f.z());
      value[2 * k] = yz * (1 - f.x());
      value[2 * k + 1] = yz * f.x();
    }
  }
  float value[8];
};

/// The symmetric positive definite system of the band's nodes. A vector of it holds the numbers of
/// the nodes run by run; the one that is multiplied is a whole grid, zero beside the band.
class BandSystem {
 public:
  BandSystem(const ScalarGrid& grid, const std::vector<ScreenedPoint>& points, int reach)
      : points_(points), pitch_(grid.pitch()), slab_(grid.slab()) {
    std::vector<Eigen::Vector3f> positions;
    positions.reserve(points.size());
    for (const ScreenedPoint& point : points) positions.push_back(point.position);
    // Where each row's first run is among all runs, to find the nodes of a point.
    std::vector<int> first_run(static_cast<std::size_t>(grid.size().y()) * grid.size().z() + 1, 0);
    const std::vector<NodeRun> band = band_about(positions, grid.size(), reach);
    for (const NodeRun& run : band) {
      runs_.push_back({grid.index(run.x, run.y, run.z), static_cast<int>(size_), run.length});
      size_ += run.length;
      ++first_run[run.z * grid.size().y() + run.y + 1];
    }
    for (std::size_t i = 1; i < first_run.size(); ++i) first_run[i] += first_run[i - 1];
    for (const ScreenedPoint& point : points) {
      const Eigen::Vector3i cell = point.position.cast<int>();
      Cell nodes{CellWeights(point.position), grid.index(cell.x(), cell.y(), cell.z()), {}};
      for (int k = 0; k < 4; ++k) {
        int r = first_run[(cell.z() + (k >> 1)) * grid.size().y() + cell.y() + (k & 1)];
        while (band[r].x + band[r].length <= cell.x()) ++r;
        nodes.in_vector[k] = runs_[r].in_vector + cell.x() - band[r].x;
      }
      cells_.push_back(nodes);
    }
  }

  std::size_t size() const { return size_; }

  /// The grid's value at each point.
  float at_point(const float* grid, std::size_t i) const {
    const Cell& cell = cells_[i];
    const float* node = grid + cell.in_grid;
    const float* w = cell.weights.value;
    return w[0] * node[0] + w[1] * node[1] + w[2] * node[pitch_] + w[3] * node[pitch_ + 1] +
           w[4] * node[slab_] + w[5] * node[slab_ + 1] + w[6] * node[slab_ + pitch_] +
           w[7] * node[slab_ + pitch_ + 1];
  }
  void add_at_point(float* vector, std::size_t i, float amount) const {
    const Cell& cell = cells_[i];
    for (int k = 0; k < 4; ++k) {
      vector[cell.in_vector[k]] += cell.weights.value[2 * k] * amount;
      vector[cell.in_vector[k] + 1] += cell.weights.value[2 * k + 1] * amount;
    }
  }

  /// vector = Σ weight (level - u(p)) b(p), with b the linear weights.
  void pull(const float* u, float level, float* vector) const {
    std::fill_n(vector, size_, 0.f);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      add_at_point(vector, i, points_[i].weight * (level - at_point(u, i)));
    }
  }

  /// out = (-L + Σ weight b b^T) grid.
  void multiply(const float* grid, float* out) const {
    for (const Run& run : runs_) {
      const float* c = grid + run.in_grid;
      float* result = out + run.in_vector;
      for (int i = 0; i < run.length; ++i) {
        result[i] = 6 * c[i] - c[i - 1] - c[i + 1] - c[i - pitch_] - c[i + pitch_] - c[i - slab_] -
                    c[i + slab_];
      }
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
      add_at_point(out, i, points_[i].weight * at_point(grid, i));
    }
  }

  void inverse_diagonal(float* out) const {
    std::fill_n(out, size_, 6.f);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const float* w = cells_[i].weights.value;
      for (int k = 0; k < 4; ++k) {
        out[cells_[i].in_vector[k]] += points_[i].weight * w[2 * k] * w[2 * k];
        out[cells_[i].in_vector[k] + 1] += points_[i].weight * w[2 * k + 1] * w[2 * k + 1];
      }
    }
    for (std::size_t i = 0; i < size_; ++i) out[i] = 1 / out[i];
  }

  /// Zero on the band and the nodes beside it, the only ones that multiply() reads.
  void clear(float* grid) const {
    for (const Run& run : runs_) {
      for (const std::ptrdiff_t step : {std::ptrdiff_t{0}, pitch_, -pitch_, slab_, -slab_}) {
        std::fill_n(grid + run.in_grid + step - 1, run.length + 2, 0.f);
      }
    }
  }

  /// grid = vector + beta grid, on the band.
  void advance(float* grid, float beta, const float* vector) const {
    for (const Run& run : runs_) {
      float* p = grid + run.in_grid;
      const float* z = vector + run.in_vector;
      for (int i = 0; i < run.length; ++i) p[i] = z[i] + beta * p[i];
    }
  }

  /// grid += alpha direction, on the band.
  void add(float* grid, float alpha, const float* direction) const {
    for (const Run& run : runs_) {
      for (int i = 0; i < run.length; ++i) {
        grid[run.in_grid + i] += alpha * direction[run.in_grid + i];
      }
    }
  }

  /// The product of a grid, on the band, and a vector.
  double dot(const float* grid, const float* vector) const {
    double sum = 0;
    for (const Run& run : runs_) {
      sum += partial_dot(grid + run.in_grid, vector + run.in_vector, run.length);
    }
    return sum;
  }

  /// Four sums side by side, so that they can be done at once.
  static double partial_dot(const float* a, const float* b, std::size_t length) {
    float sums[4] = {};
    std::size_t i = 0;
    for (; i + 4 <= length; i += 4) {
      for (int k = 0; k < 4; ++k) sums[k] += a[i + k] * b[i + k];
    }
    for (; i < length; ++i) sums[0] += a[i] * b[i];
    return static_cast<double>(sums[0] + sums[1]) + (sums[2] + sums[3]);
  }

 private:
  struct Run {
    std::ptrdiff_t in_grid;
    int in_vector;
    int length;
  };
  struct Cell {
    CellWeights weights;
    std::ptrdiff_t in_grid;
    int in_vector[4];  // of the nodes with lower x
  };
  const std::vector<ScreenedPoint>& points_;
  std::vector<Run> runs_;
  std::vector<Cell> cells_;
  std::size_t size_ = 0;
  std::ptrdiff_t pitch_;
  std::ptrdiff_t slab_;
};

}  // namespace

float interpolated(const ScalarGrid& field, const Eigen::Vector3f& p) {
  const CellWeights weights(p);
  const Eigen::Vector3i cell = p.cast<int>();
  float sum = 0;
  for (int k = 0; k < 4; ++k) {
    const float* node =
        field.data() + field.index(cell.x(), cell.y() + (k & 1), cell.z() + (k >> 1));
    sum += weights.value[2 * k] * node[0] + weights.value[2 * k + 1] * node[1];
  }
  return sum;
}

void screen(ScalarGrid& field, const std::vector<ScreenedPoint>& points, float level,
            const ScreeningOptions& options) {
  if (points.empty() || options.iterations == 0) return;
  constexpr std::size_t kBlock = 256;  // of sums in single precision
  const BandSystem system(field, points, options.reach);
  const std::size_t n = system.size();
  ScalarGrid direction(field.size());
  std::vector<float> residual(n);
  std::vector<float> product(n);
  std::vector<float> preconditioner(n);
  float* p = direction.data();
  system.clear(p);
  system.pull(field.data(), level, residual.data());
  system.inverse_diagonal(preconditioner.data());
  double rho = 0;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    for (std::size_t i = 0; i < n; ++i) product[i] = preconditioner[i] * residual[i];
    double next_rho = 0;
    for (std::size_t i = 0; i < n; i += kBlock) {
      next_rho += BandSystem::partial_dot(&product[i], &residual[i], std::min(kBlock, n - i));
    }
    if (!(next_rho > 0)) return;
    system.advance(p, static_cast<float>(iteration == 0 ? 0 : next_rho / rho), product.data());
    rho = next_rho;
    system.multiply(p, product.data());
    const double curvature = system.dot(p, product.data());
    if (!(curvature > 0)) return;
    const auto alpha = static_cast<float>(rho / curvature);
    system.add(field.data(), alpha, p);
    for (std::size_t i = 0; i < n; ++i) residual[i] -= alpha * product[i];
  }
}

}  // namespace prehend::surface
