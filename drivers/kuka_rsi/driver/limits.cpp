#include "drivers/kuka_rsi/driver/limits.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace prehend::drivers::kuka_rsi {
namespace {

constexpr double kPositionSlack = 1e-6;      // rad; check_trajectory's
constexpr double kSpeedSlack = 1.0002;       // of the limit; that of check_trajectory is half of it
constexpr double kAccelerationSlack = 1.01;  // of the limit: differences of cycles, not derivatives

}  // namespace

const char* to_string(Breach breach) {
  switch (breach) {
    case Breach::kNone:
      return "keeps its limits";
    case Breach::kNotFinite:
      return "is no number";
    case Breach::kPosition:
      return "is beyond its limit of position";
    case Breach::kSpeed:
      return "is faster than its limit";
    case Breach::kAcceleration:
      return "gains speed faster than its limit";
    case Breach::kCorrection:
      return "is farther from where the controller's program stands than largest_correction";
    case Breach::kTool:
      return "leaves its box";
  }
  return "?";
}

Limits::Limits(robot::KinematicChain chain, const Options& options)
    : chain_(std::move(chain)), options_(options) {
  if (chain_.size() != static_cast<int>(kAxes)) {
    throw std::invalid_argument("the arm has " + std::to_string(chain_.size()) +
                                " joints, but a KUKA over RSI has six; take a platform with "
                                "six, as kr5_pg70");
  }
  for (const robot::ChainJoint& joint : chain_.joints()) {
    if (joint.is_revolute && std::isfinite(joint.lower) && std::isfinite(joint.upper) &&
        std::isfinite(joint.max_velocity)) {
      continue;
    }
    throw std::invalid_argument("joint '" + joint.name +
                                "' does not turn within limits of position and speed");
  }
  if (!(options.speed_share > 0 && options.speed_share <= 1)) {
    throw std::invalid_argument("the share of the joints' speeds must be in (0, 1]");
  }
  for (const double value : {options.acceleration, options.largest_correction}) {
    if (!(value > 0 && std::isfinite(value))) {
      throw std::invalid_argument("acceleration and largest_correction must be positive");
    }
  }
  if (options.box && !(options.box->lower.array() < options.box->upper.array()).all()) {
    throw std::invalid_argument(
        "the tool's box has no inside; give its lower corner first: x y z x y z");
  }
}

Eigen::Vector3d Limits::tool_at(const Axes& q) const {
  const Eigen::Map<const Eigen::Matrix<double, kAxes, 1>> positions(q.data());
  return options_.X_WB * (chain_.forward(positions) * options_.p_FT);
}

bool Limits::tool_is_inside(const Axes& q) const {
  return !options_.box || options_.box->contains(tool_at(q));
}

Broken Limits::check(const Axes& reference, const Axes& now, const Axes& velocity, const Axes& next,
                     double cycle) const {
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!std::isfinite(next[i])) return {Breach::kNotFinite, i};
    if (next[i] < lower(i) - kPositionSlack || next[i] > upper(i) + kPositionSlack) {
      return {Breach::kPosition, i};
    }
    if (std::abs(next[i] - reference[i]) > options_.largest_correction) {
      return {Breach::kCorrection, i};
    }
    const double fast = (next[i] - now[i]) / cycle;
    if (std::abs(fast) > kSpeedSlack * speed(i)) return {Breach::kSpeed, i};
    if (std::abs(fast - velocity[i]) > kAccelerationSlack * options_.acceleration * cycle) {
      return {Breach::kAcceleration, i};
    }
  }
  if (!tool_is_inside(next)) return {Breach::kTool, 0};
  return {};
}

void Limits::brake(Axes& q, Axes& velocity, double cycle) const {
  const double step = options_.acceleration * cycle;
  for (std::size_t i = 0; i < kAxes; ++i) {
    velocity[i] -= std::clamp(velocity[i], -step, step);
    const double next =
        std::clamp(q[i] + velocity[i] * cycle, std::min(q[i], lower(i)), std::max(q[i], upper(i)));
    q[i] = next;
  }
}

}  // namespace prehend::drivers::kuka_rsi
