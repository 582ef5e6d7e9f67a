#include "prehend/touch/pattern_motion.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace prehend::touch {
namespace {

constexpr double kReach = 1.5;  // texels' distances to neighbours: a grid's diagonal ones included

}  // namespace

double PatternEquations::left_over(const Eigen::Vector4d& x) const {
  if (rows.size() <= 4) return 0;
  double squares = 0;
  for (const auto& [row, change] : rows) squares += std::pow(change - row.dot(x), 2);
  return std::sqrt(squares / static_cast<double>(rows.size() - 4));
}

PatternMotion::PatternMotion(const contact::PadLayout& layout) : stencils_(layout.size()) {
  double area = 0;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    places_.emplace_back(layout.x[i], layout.y[i]);
    area = std::max(area, layout.area(i));
  }
  if (!layout.is_flat()) return;
  distance_ = std::sqrt(area);
  // The plane through a texel and its neighbours, weighted so that on a grid value and gradient are
  // smoothed alike (1 4 1 along rows and columns): else motions would look larger than they are.
  for (std::size_t i = 0; i < layout.size(); ++i) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    std::vector<std::pair<std::size_t, Eigen::Vector3d>> near;
    for (std::size_t k = 0; k < layout.size(); ++k) {
      const Eigen::Vector2d d = (places_[k] - places_[i]) / distance_;
      if (d.norm() > kReach) continue;
      const Eigen::Vector3d row(1, d.x(), d.y());
      const double weight = std::pow(4, -d.squaredNorm());
      near.emplace_back(k, weight * row);
      A += weight * row * row.transpose();
    }
    // At the pad's border it would be one-sided.
    if (A.topRightCorner<1, 2>().norm() > 0.1 * A(0, 0)) continue;
    const Eigen::Matrix3d inverse = A.inverse();
    for (const auto& [k, row] : near) stencils_[i].emplace_back(k, inverse * row);
  }
}

PatternEquations PatternMotion::between(const FeltTexels& then, const FeltTexels& now,
                                        const std::vector<bool>& ignored) const {
  PatternEquations equations;
  std::vector<double> mean(places_.size());
  double total = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    mean[i] = (then.force[i] + now.force[i]) / 2;
    total += mean[i];
    equations.mean_square += mean[i] * mean[i] / static_cast<double>(places_.size());
    equations.center += mean[i] * places_[i];
  }
  equations.center /= total;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    bool usable = !stencils_[i].empty();
    double near = 0, change = 0;
    Eigen::Vector3d p = Eigen::Vector3d::Zero();  // mean, and its gradient
    for (const auto& [k, weight] : stencils_[i]) {
      usable = usable && then.state[k] <= Texel::kTouched && now.state[k] <= Texel::kTouched &&
               (ignored.empty() || !ignored[k]);
      near += mean[k];
      change += weight[0] * (now.force[k] - then.force[k]);
      p += weight * mean[k];
    }
    if (!usable || near <= 0) continue;
    const Eigen::Vector2d r = (places_[i] - equations.center) / distance_;
    const Eigen::Vector4d row(-p.y(), -p.z(), -(p.z() * r.x() - p.y() * r.y()), p.x());
    equations.rows.emplace_back(row, change);
    equations.A += row * row.transpose();
    equations.right += change * row;
  }
  return equations;
}

}  // namespace prehend::touch
