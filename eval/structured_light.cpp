#include "eval/structured_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace prehend::eval {
namespace {

using geometry::DepthImage;

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
constexpr double kEdge = 0.02;      // m: a larger step between pixels is an edge
constexpr int kBlotch = 9;          // pixels between the corners of blotches
constexpr double kGapAtEdge = 0.5;  // probability that the farther pixel at an edge has no depth

// Smooth noise, evenly spread over 0..1 in the mean: values at corners, blended in between.
class Blotches {
 public:
  Blotches(int width, int height, std::mt19937& random)
      : columns_(width / kBlotch + 2), corners_(columns_ * (height / kBlotch + 2)) {
    std::uniform_real_distribution<double> uniform(0, 1);
    for (double& corner : corners_) corner = uniform(random);
  }
  double at(int column, int row) const {
    const int c = column / kBlotch, r = row / kBlotch;
    const double x = static_cast<double>(column % kBlotch) / kBlotch,
                 y = static_cast<double>(row % kBlotch) / kBlotch;
    const auto corner = [&](int dc, int dr) {
      return corners_[static_cast<std::size_t>((r + dr) * columns_ + c + dc)];
    };
    return (1 - y) * ((1 - x) * corner(0, 0) + x * corner(1, 0)) +
           y * ((1 - x) * corner(0, 1) + x * corner(1, 1));
  }

 private:
  int columns_;
  std::vector<double> corners_;
};

double cosine_of_view(const DepthImage& depth, const geometry::PinholeCamera& camera, int column,
                      int row) {
  const auto point = [&](int c, int r) {
    const double z = depth.at(c, r);
    return Eigen::Vector3d((c - camera.cx) / camera.fx * z, (r - camera.cy) / camera.fy * z, z);
  };
  const Eigen::Vector3d p = point(column, row);
  const Eigen::Vector3d normal =
      (point(column + 1, row) - p).cross(point(column, row + 1) - p).normalized();
  return std::abs(normal.dot(p.normalized()));
}

}  // namespace

DepthImage structured_light(const DepthImage& depth, const geometry::Image<std::int16_t>& labels,
                            const geometry::PinholeCamera& camera,
                            const StructuredLightNoise& noise) {
  std::mt19937 random(noise.seed);
  const Blotches blotches(depth.width, depth.height, random),
      wander(depth.width, depth.height, random), wander_up(depth.width, depth.height, random);
  std::normal_distribution<double> normal(0, 1);
  std::uniform_real_distribution<double> uniform(0, 1);
  // Of the blotches' values the part `missing` is below this.
  std::vector<double> values;
  for (int row = 0; row < depth.height; ++row) {
    for (int column = 0; column < depth.width; ++column) {
      if (labels.at(column, row) == 0) values.push_back(blotches.at(column, row));
    }
  }
  double swallowed = -1;
  if (!values.empty() && noise.missing > 0) {
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>(
                                          noise.missing * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), nth, values.end());
    swallowed = *nth;
  }
  DepthImage seen(depth.width, depth.height, kNothing);
  for (int row = 1; row + 1 < depth.height; ++row) {
    for (int column = 1; column + 1 < depth.width; ++column) {
      // Edges wander: the depth is that of a pixel beside.
      const int from_column = std::clamp(
          column + static_cast<int>(std::lround((2 * wander.at(column, row) - 1) * noise.bleed)), 1,
          depth.width - 2);
      const int from_row = std::clamp(
          row + static_cast<int>(std::lround((2 * wander_up.at(column, row) - 1) * noise.bleed)), 1,
          depth.height - 2);
      const double z = depth.at(from_column, from_row);
      const double gap = uniform(random), error = normal(random);
      if (!std::isfinite(z)) continue;
      double nearest = z;
      for (const auto& [c, r] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        const double other = depth.at(from_column + c, from_row + r);
        if (std::isfinite(other)) nearest = std::min(nearest, other);
      }
      if (z - nearest > kEdge && gap < kGapAtEdge) continue;
      if (labels.at(column, row) == 0 && blotches.at(column, row) < swallowed) continue;
      if (!(cosine_of_view(depth, camera, from_column, from_row) > noise.grazing)) continue;
      const double noisy = z + noise.deviation * z * z * error;
      const double step = noise.step * z * z;
      seen.at(column, row) = static_cast<float>(std::round(noisy / step) * step);
    }
  }
  return seen;
}

}  // namespace prehend::eval
