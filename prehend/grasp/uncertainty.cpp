#include "prehend/grasp/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>

#include "prehend/text/require.h"

namespace prehend::grasp {
namespace {

// Standard normal, the same on every standard library (G. E. P. Box and M. E. Muller, 1958).
class Normal {
 public:
  explicit Normal(std::uint64_t seed) : random_(seed) {}
  double uniform() { return static_cast<double>(random_() >> 11) * 0x1.0p-53; }
  double next() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }
  Eigen::Vector3d vector() {
    const double x = next(), y = next();
    return {x, y, next()};
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace

void UncertaintyOptions::validate() const {
  const text::Require require{"UncertaintyOptions."};
  require(samples >= 0, "samples must not be negative");
  require(position_deviation >= 0, "position_deviation must not be negative");
  require(rotation_deviation >= 0, "rotation_deviation must not be negative");
  require(least_friction > 0 && largest_friction >= least_friction,
          "least_friction must be positive and not above largest_friction");
}

void add_remark(const std::string& more, std::string* remark) {
  *remark += (remark->empty() ? "" : "; ") + more;
}

std::vector<Disturbance> disturbances(const UncertaintyOptions& options) {
  Normal random(options.seed);
  std::vector<Disturbance> all(static_cast<std::size_t>(options.samples));
  for (Disturbance& one : all) {
    one.X_GD.translation() = options.position_deviation * random.vector();
    const Eigen::Vector3d turn = options.rotation_deviation * random.vector();
    if (turn.norm() > 0) {
      one.X_GD.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    }
    one.friction = options.least_friction +
                   random.uniform() * (options.largest_friction - options.least_friction);
  }
  return all;
}

std::optional<double> share_held(const std::vector<std::optional<bool>>& held, std::size_t first,
                                 std::size_t count) {
  const auto begin = held.begin() + static_cast<std::ptrdiff_t>(first);
  const auto end = begin + static_cast<std::ptrdiff_t>(count);
  if (std::find(begin, end, std::nullopt) != end) return std::nullopt;
  return static_cast<double>(std::count(begin, end, true)) / static_cast<double>(count);
}

}  // namespace prehend::grasp
