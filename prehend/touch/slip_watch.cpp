#include "prehend/touch/slip_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/symmetric_solve.h"
#include "prehend/text/require.h"

namespace prehend::touch {
namespace {

Eigen::Vector2d place(const contact::PadLayout& layout, std::size_t i) {
  return {layout.x[i], layout.y[i]};
}

}  // namespace

SlipWatch::SlipWatch(FeltPad pad, const SlipOptions& options)
    : pad_(std::move(pad)), options_(options), motion_(pad_.layout) {
  const text::Require require{"SlipOptions."};
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  require(positive(options.window), "window must be positive");
  require(positive(options.least_slip), "least_slip must be positive");
  require(positive(options.largest_deviation), "largest_deviation must be positive");
  require(std::isfinite(options.gain_deviation) && options.gain_deviation >= 0,
          "gain_deviation must not be negative");
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
  const PatternEquations equations = motion_.between(then.felt, now.felt);
  const Eigen::Matrix4d& A = equations.A;
  const double distance = motion_.distance();
  const std::size_t count = equations.rows.size();
  reading->center = equations.center;
  reading->duration = now.time - then.time;
  const Eigen::Vector4d x = geometry::symmetric_solve<4>(A, equations.right);
  const double noise =
      std::max(options_.gain_deviation * std::sqrt(equations.mean_square), equations.left_over(x));
  // Along which shift the pattern tells least; the turn is known where some of it is off centre.
  const auto deviation_of = [&](int k) {
    const Eigen::Vector4d unit = Eigen::Vector4d::Unit(k);
    const Eigen::Vector4d column = geometry::symmetric_solve<4>(A, unit);
    const bool solved = count > 4 && (A * column - unit).norm() < 1e-6 && column[k] > 0;
    return solved ? noise * std::sqrt(column[k]) : std::numeric_limits<double>::infinity();
  };
  reading->deviation = distance * std::max(deviation_of(0), deviation_of(1));
  if (reading->deviation > options_.largest_deviation) {
    reading->reason = "the pattern is too even to show whether it moves";
    return;
  }
  reading->determined = true;
  reading->shift = distance * x.head<2>();
  // A round pattern does not show whether it turns; then it counts as not turning.
  const double turn_deviation = deviation_of(2);
  reading->turn = turn_deviation * distance <= options_.largest_deviation ? x[2] : 0;
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
