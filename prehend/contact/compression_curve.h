#pragma once

#include <vector>

namespace prehend::contact {

/// Force of a foam over its compression, from measured samples: monotone cubic Hermite
/// interpolation (Fritsch and Carlson, "Monotone Piecewise Cubic Interpolation", 1980), continued
/// beyond the last sample with the slope there. Starts at (0, 0). Once continuously differentiable.
class CompressionCurve {
 public:
  struct Sample {
    double depth = 0;  // m
    double force = 0;  // N, of a texel of reference area
  };

  /// @throws std::invalid_argument naming the sample: fewer than two, not finite, first not
  /// (0, 0), depths that do not increase, forces that decrease, a last force of zero.
  explicit CompressionCurve(const std::vector<Sample>& samples);

  double force(double depth) const;      // N; zero for depth <= 0
  double stiffness(double depth) const;  // N/m, the derivative; that of depth 0 below 0
  double mean_stiffness() const;         // N/m, last sample's force over its depth

 private:
  struct Knot {
    double depth, force, slope;
  };
  std::size_t interval(double depth) const;
  std::vector<Knot> knots_;
};

}  // namespace prehend::contact
