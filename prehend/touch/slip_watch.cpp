#include "prehend/touch/slip_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <Eigen/LU>

#include "prehend/geometry/symmetric_solve.h"
#include "prehend/text/require.h"

namespace prehend::touch {
namespace {

constexpr double kReach = 1.5;  // texels' distances to neighbours: a grid's diagonal ones included

Eigen::Vector2d place(const contact::PadLayout& layout, std::size_t i) {
  return {layout.x[i], layout.y[i]};
}

}  // namespace

SlipWatch::SlipWatch(FeltPad pad, const SlipOptions& options)
    : pad_(std::move(pad)), options_(options) {
  const text::Require require{"SlipOptions."};
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  require(positive(options.window), "window must be positive");
  require(positive(options.least_slip), "least_slip must be positive");
  require(positive(options.largest_deviation), "largest_deviation must be positive");
  require(std::isfinite(options.gain_deviation) && options.gain_deviation >= 0,
          "gain_deviation must not be negative");
  const contact::PadLayout& layout = pad_.layout;
  stencils_.resize(layout.size());
  if (!layout.is_flat()) return;
  double area = 0;
  for (std::size_t i = 0; i < layout.size(); ++i) area = std::max(area, layout.area(i));
  distance_ = std::sqrt(area);
  // The plane through a texel and its neighbours, weighted so that on a grid value and gradient are
  // smoothed alike (1 4 1 along rows and columns): else motions would look larger than they are.
  for (std::size_t i = 0; i < layout.size(); ++i) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    std::vector<std::pair<std::size_t, Eigen::Vector3d>> near;
    for (std::size_t k = 0; k < layout.size(); ++k) {
      const Eigen::Vector2d d = (place(layout, k) - place(layout, i)) / distance_;
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

SlipReading SlipWatch::update(double time, const std::vector<double>& counts) {
  if (!frames_.empty() && !(time > frames_.back().time)) frames_.clear();
  frames_.push_back({time, felt_texels(pad_, counts)});
  // The oldest one that is kept is as old as the window, or the next older.
  while (frames_.size() > 2 && time - frames_[1].time >= options_.window * (1 - 1e-9)) {
    frames_.pop_front();
  }
  const Frame& now = frames_.back();
  SlipReading reading;
  reading.texels.assign(counts.size(), TexelSlip::kFree);
  bool touched = false;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (now.felt.force[i] <= 0) continue;
    reading.texels[i] = TexelSlip::kUnknown;
    touched = true;
  }
  if (!touched) {
    reading.reason = "nothing touches";
  } else if (!pad_.layout.is_flat()) {
    reading.reason = "the pad is curved, whose patterns are not followed";
  } else if (frames_.size() < 2 || time - frames_.front().time < options_.window * (1 - 1e-9)) {
    reading.reason = fmt::format("no frame of {} s ago yet", options_.window);
  } else {
    compare(frames_.front(), now, &reading);
  }
  return reading;
}

void SlipWatch::compare(const Frame& then, const Frame& now, SlipReading* reading) const {
  const contact::PadLayout& layout = pad_.layout;
  std::vector<double> mean(layout.size());
  double total = 0, square = 0;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    mean[i] = (then.felt.force[i] + now.felt.force[i]) / 2;
    total += mean[i];
    square += mean[i] * mean[i];
    reading->center += mean[i] * place(layout, i);
  }
  reading->center /= total;
  reading->duration = now.time - then.time;
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  std::vector<std::pair<Eigen::Vector4d, double>> equations;  // lengths in texels' distances
  for (std::size_t i = 0; i < layout.size(); ++i) {
    bool usable = !stencils_[i].empty();
    double near = 0, change = 0;
    Eigen::Vector3d p = Eigen::Vector3d::Zero();  // mean, and its gradient
    for (const auto& [k, weight] : stencils_[i]) {
      usable =
          usable && then.felt.state[k] <= Texel::kTouched && now.felt.state[k] <= Texel::kTouched;
      near += mean[k];
      change += weight[0] * (now.felt.force[k] - then.felt.force[k]);
      p += weight * mean[k];
    }
    if (!usable || near <= 0) continue;
    const Eigen::Vector2d r = (place(layout, i) - reading->center) / distance_;
    const Eigen::Vector4d row(-p.y(), -p.z(), -(p.z() * r.x() - p.y() * r.y()), p.x());
    equations.emplace_back(row, change);
    A += row * row.transpose();
    right += change * row;
  }
  const Eigen::Vector4d x = geometry::symmetric_solve<4>(A, right);
  double left_over = 0;
  for (const auto& [row, change] : equations) left_over += std::pow(change - row.dot(x), 2);
  const auto count = static_cast<double>(equations.size());
  const double noise =
      std::max(options_.gain_deviation * std::sqrt(square / static_cast<double>(layout.size())),
               count > 4 ? std::sqrt(left_over / (count - 4)) : 0.0);
  // Along which shift the pattern tells least; the turn is known where some of it is off centre.
  const auto deviation_of = [&](int k) {
    const Eigen::Vector4d unit = Eigen::Vector4d::Unit(k);
    const Eigen::Vector4d column = geometry::symmetric_solve<4>(A, unit);
    const bool solved = count > 4 && (A * column - unit).norm() < 1e-6 && column[k] > 0;
    return solved ? noise * std::sqrt(column[k]) : std::numeric_limits<double>::infinity();
  };
  reading->deviation = distance_ * std::max(deviation_of(0), deviation_of(1));
  if (reading->deviation > options_.largest_deviation) {
    reading->reason = "the pattern is too even to show whether it moves";
    return;
  }
  reading->determined = true;
  reading->shift = distance_ * x.head<2>();
  // A round pattern does not show whether it turns; then it counts as not turning.
  const double turn_deviation = deviation_of(2);
  reading->turn = turn_deviation * distance_ <= options_.largest_deviation ? x[2] : 0;
  const double least = std::max(options_.least_slip, 3 * reading->deviation);
  for (std::size_t i = 0; i < layout.size(); ++i) {
    if (now.felt.force[i] <= 0) continue;
    const Eigen::Vector2d r = place(layout, i) - reading->center;
    const Eigen::Vector2d moved = reading->shift + reading->turn * Eigen::Vector2d(-r.y(), r.x());
    const bool slips = moved.norm() > least;
    reading->texels[i] = slips ? TexelSlip::kSlips : TexelSlip::kSticks;
    reading->slipping += slips ? 1 : 0;
  }
}

}  // namespace prehend::touch
