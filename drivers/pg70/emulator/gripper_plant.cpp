#include "drivers/pg70/emulator/gripper_plant.h"

#include <algorithm>
#include <cmath>

namespace prehend::drivers::pg70 {
namespace {

constexpr double kFreeCurrent = 0.15;  // A that move the empty jaws against friction
constexpr double kFreeSpeed = 0.083;   // m/s that a current drives empty jaws with
constexpr double kAcceleration = 0.32;

}  // namespace

// [m/s] Such that it can still stop at the target.
double SimpleGripper::wanted_speed() const {
  switch (command_.drive) {
    case Drive::kPosition: {
      const double way = command_.value - motion_.opening;
      const double a = command_.acceleration > 0 ? command_.acceleration : kAcceleration;
      return std::copysign(std::min(command_.speed, std::sqrt(2 * a * std::abs(way))), way);
    }
    case Drive::kVelocity:
      return command_.value;
    case Drive::kCurrent:
      return std::abs(command_.value) < kFreeCurrent ? 0
                                                     : std::copysign(kFreeSpeed, command_.value);
    default:
      return 0;
  }
}

GripperPlant::Motion SimpleGripper::advance(double seconds) {
  constexpr double kStep = 1e-3;  // s
  while (seconds > 0) {
    const double h = std::min(seconds, kStep);
    seconds -= h;
    motion_.time += h;
    const double a = command_.acceleration > 0 ? command_.acceleration : kAcceleration;
    const double wanted = wanted_speed();
    motion_.velocity += std::clamp(wanted - motion_.velocity, -a * h, a * h);
    double opening = motion_.opening + motion_.velocity * h;
    if (command_.drive == Drive::kPosition &&
        (opening - command_.value) * (motion_.opening - command_.value) <= 0 &&
        std::abs(motion_.velocity) <= 2 * a * h) {
      opening = command_.value;  // the last step of a trapezoid
      motion_.velocity = 0;
    }
    const double least = std::max(0.0, object_.value_or(0.0));
    const double free = stuck_ ? motion_.opening : std::clamp(opening, least, max_opening_);
    const bool is_blocked = free != opening;
    motion_.opening = free;
    if (is_blocked) motion_.velocity = 0;
    const double sign = wanted < 0 ? -1 : wanted > 0 ? 1 : 0;
    const double limit =
        command_.drive == Drive::kCurrent ? std::abs(command_.value) : command_.current;
    motion_.current = sign * (is_blocked ? limit : std::min(limit, kFreeCurrent));
  }
  return motion_;
}

}  // namespace prehend::drivers::pg70
