#include "drivers/kuka_rsi/driver/motion.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace prehend::drivers::kuka_rsi {
namespace {

constexpr double kFadeShare = 0.3;    // of the acceleration, for what the start is off
constexpr double kFadePeak = 5.7735;  // of the fade's acceleration, times its time squared
constexpr std::size_t kMostSetPoints = 1000000;  // 67 minutes at 4 ms
constexpr std::size_t kLooksAtBraking = 4;       // every so many set points, and of its cycles

double fade(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return 1 - s * s * s * (10 + s * (-15 + 6 * s));
}

Axes to_axes(const robot::Positions& q) {
  Axes axes{};
  for (std::size_t i = 0; i < kAxes; ++i) axes[i] = q[static_cast<Eigen::Index>(i)];
  return axes;
}

bool brakes_inside(Axes q, Axes velocity, const Limits& limits, double cycle) {
  std::size_t look = 0;
  while (std::any_of(velocity.begin(), velocity.end(), [](double v) { return v != 0; })) {
    limits.brake(q, velocity, cycle);
    if (look++ % kLooksAtBraking == 0 && !limits.tool_is_inside(q)) return false;
  }
  return limits.tool_is_inside(q);
}

[[noreturn]] void refuse(const Broken& broken, double time, const Limits& limits, const Axes& q) {
  if (broken.breach == Breach::kTool) {
    const Eigen::Vector3d p_W = limits.tool_at(q);
    throw std::invalid_argument(
        fmt::format("after {:.3f} s the tool at ({:.3f}, {:.3f}, {:.3f}) m {}", time, p_W.x(),
                    p_W.y(), p_W.z(), to_string(broken.breach)));
  }
  throw std::invalid_argument(fmt::format("after {:.3f} s joint '{}' {}", time,
                                          limits.chain().joints()[broken.axis].name,
                                          to_string(broken.breach)));
}

}  // namespace

std::vector<Axes> set_points_of(const simulation::ArmTrajectory& trajectory, const Axes& start,
                                const Axes& reference, const Limits& limits, double cycle) {
  const Axes first = to_axes(trajectory.points.front().position);
  double off = 0;
  for (std::size_t i = 0; i < kAxes; ++i) off = std::max(off, std::abs(start[i] - first[i]));
  const double fading = std::sqrt(kFadePeak * off / (kFadeShare * limits.options().acceleration));
  const double duration = std::max(trajectory.duration(), fading);
  const double count = std::ceil(duration / cycle - 1e-9);
  if (count > static_cast<double>(kMostSetPoints)) {
    throw std::invalid_argument(fmt::format(
        "the trajectory takes {:.0f} s, which are more than {} cycles; ask for it in parts",
        duration, kMostSetPoints));
  }
  std::vector<Axes> set_points;
  set_points.reserve(static_cast<std::size_t>(count) + 1);
  Axes now = start, velocity{};
  for (std::size_t k = 1; k <= static_cast<std::size_t>(std::max(1.0, count)); ++k) {
    const double time = static_cast<double>(k) * cycle;
    Axes next = to_axes(trajectory.at(time).position);
    const double share = fading > 0 ? fade(time / fading) : 0;
    for (std::size_t i = 0; i < kAxes; ++i) next[i] += share * (start[i] - first[i]);
    if (const Broken broken = limits.check(reference, now, velocity, next, cycle)) {
      refuse(broken, time, limits, next);
    }
    for (std::size_t i = 0; i < kAxes; ++i) velocity[i] = (next[i] - now[i]) / cycle;
    now = next;
    set_points.push_back(next);
    if (limits.options().box && k % kLooksAtBraking == 0 &&
        !brakes_inside(now, velocity, limits, cycle)) {
      throw std::invalid_argument(fmt::format(
          "after {:.3f} s the tool could not stop inside its box; go there slower", time));
    }
  }
  // It ends at rest.
  if (const Broken broken = limits.check(reference, now, velocity, now, cycle)) {
    refuse(broken, duration, limits, now);
  }
  return set_points;
}

}  // namespace prehend::drivers::kuka_rsi
