#include "prehend/grasp/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
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

std::vector<double> shape_weights(const surface::ObjectModel& object) {
  const std::size_t shapes = 1 + object.alternatives_W.size();
  std::vector<double> weights = object.shape_weights;
  if (weights.empty()) weights.assign(shapes, 1);
  double sum = 0;
  bool known = weights.size() == shapes;
  for (const double weight : weights) {
    known = known && weight >= 0;
    sum += weight;
  }
  if (!known || !(sum > 0) || !std::isfinite(sum)) {
    throw geometry::InputError("The object's weights are not those of its shapes",
                               "Give one, not negative, for the mesh and for each alternative");
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

std::vector<double> shares_held(const std::vector<std::optional<bool>>& held, std::size_t first,
                                std::size_t count, std::size_t shapes) {
  std::vector<double> held_on(shapes, 0), tried_on(shapes, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const std::optional<bool>& one = held[first + i];
    if (!one) return {};
    tried_on[i % shapes] += 1;
    held_on[i % shapes] += *one ? 1 : 0;
  }
  for (std::size_t k = 0; k < shapes; ++k) held_on[k] /= tried_on[k];
  return held_on;
}

std::optional<double> mean_share(const std::vector<double>& shares,
                                 const std::vector<double>& weights) {
  double sum = 0, of = 0;
  for (std::size_t k = 0; k < shares.size(); ++k) {
    if (std::isnan(shares[k])) continue;
    sum += weights[k] * shares[k];
    of += weights[k];
  }
  if (!(of > 0)) return std::nullopt;
  return sum / of;
}

}  // namespace prehend::grasp
