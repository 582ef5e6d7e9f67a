// How the emulated hand's controllers move on.

#include <algorithm>
#include <cmath>

#include "drivers/sdh/emulator/hand.h"

namespace prehend::drivers::sdh {
namespace {

constexpr double kStanding = 0.5;  // degree/s
constexpr double kLag = 1.0;       // degree behind its reference: something is in its way

// Of a motion from rest to rest over `way` at no more than `speed`.
double ramp_time(double way, double speed, double acceleration) {
  if (way <= 0) return 0;
  if (speed <= 0 || acceleration <= 0) return 1e9;
  const double ramps = speed * speed / acceleration;
  return way > ramps ? way / speed + speed / acceleration : 2 * std::sqrt(way / acceleration);
}

}  // namespace

// All axes start and end together, the slowest decides (SDHLibrary-CPP, sdh.h). Returns how long
// that takes [s].
double Hand::prepare_profile(const AxisValues& target, const AxisValues& speed) {
  constexpr double kSineSquarePeak = 2;  // times its mean speed
  double duration = 0;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double way = std::abs(target[i] - reference_[i]);
    const double own = profile_ == 0
                           ? (way > 0 ? kSineSquarePeak * way / std::max(speed[i], 1e-6) : 0)
                           : ramp_time(way, speed[i], acceleration_[i]);
    duration = std::max(duration, own);
  }
  return duration;
}

double Hand::begin_profile(const AxisValues& target, const AxisValues& speed) {
  const double duration = prepare_profile(target, speed);
  profile_begin_ = motion_.time;
  profile_time_ = duration;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double way = std::abs(target[i] - reference_[i]);
    sent_[i] = target[i];
    start_[i] = reference_[i];
    if (profile_ == 0) velocity_[i] = 0;
    // The speed with which this axis arrives with the others, from rest: way = v (T - v / a).
    const double a = acceleration_[i], at = a * duration;
    pace_[i] = std::min(speed[i], 0.5 * (at - std::sqrt(std::max(0.0, at * at - 4 * a * way))));
    ramp_[i] = a;
    moving_[i] = std::abs(target[i] - motion_.position[i] / kDegree) > options_.tolerance;
    blocked_[i] = at_limit_[i] = false;
    standing_since_[i] = motion_.time;
  }
  return duration;
}

void Hand::advance_axis(std::size_t i, double h) {
  if (!powered_[i]) {
    reference_[i] = sent_[i] = motion_.position[i] / kDegree;
    velocity_[i] = 0;
    return;
  }
  if (controller_ != 0) {
    const double wanted = speed_[i];
    const double change = controller_ == 1 ? 1e9 : acceleration_[i] * h;
    velocity_[i] += std::clamp(wanted - velocity_[i], -change, change);
    const double next = reference_[i] + velocity_[i] * h;
    reference_[i] = std::clamp(next, options_.lower[i], options_.upper[i]);
    at_limit_[i] = next != reference_[i];
    if (at_limit_[i]) velocity_[i] = 0;
    sent_[i] = reference_[i];
    return;
  }
  if (profile_ == 0 || grip_.runs) {
    if (profile_time_ <= 0) return;
    const double share = std::clamp((motion_.time - profile_begin_) / profile_time_, 0.0, 1.0);
    const double before = reference_[i];
    reference_[i] =
        start_[i] + (sent_[i] - start_[i]) * (share - std::sin(2 * M_PI * share) / (2 * M_PI));
    velocity_[i] = h > 0 ? (reference_[i] - before) / h : 0;
    return;
  }
  const double way = sent_[i] - reference_[i];
  const double most = std::min(pace_[i], std::sqrt(2 * ramp_[i] * std::abs(way)));
  const double wanted = std::copysign(most, way);
  velocity_[i] += std::clamp(wanted - velocity_[i], -ramp_[i] * h, ramp_[i] * h);
  const double next = reference_[i] + velocity_[i] * h;
  const bool passes = (sent_[i] - next) * way <= 0;
  if (way == 0 || (passes && std::abs(velocity_[i]) <= 3 * ramp_[i] * h + 1e-6)) {
    reference_[i] = sent_[i];
    velocity_[i] = 0;
  } else {
    reference_[i] = std::clamp(next, options_.lower[i], options_.upper[i]);
  }
}

// By the plant's time: a world that is held up stands still, but is not blocked.
void Hand::look_at_axis(std::size_t i) {
  const double position = motion_.position[i] / kDegree;
  const bool stands = std::abs(motion_.velocity[i] / kDegree) < kStanding;
  const bool lags = powered_[i] && std::abs(reference_[i] - position) > kLag;
  if (!stands || !lags) standing_since_[i] = motion_.time;
  blocked_[i] = lags && motion_.time - standing_since_[i] > options_.blocked_time;
  const bool is_there = std::abs(sent_[i] - position) <= options_.tolerance &&
                        std::abs(sent_[i] - reference_[i]) < 1e-6;
  if (is_there && stands) moving_[i] = false;
}

void Hand::advance_references(double h) {
  constexpr double kStep = 2e-3;  // s
  while (h > 0) {
    const double step = std::min(h, kStep);
    h -= step;
    for (std::size_t i = 0; i < kAxes; ++i) advance_axis(i, step);
  }
  if (grip_.runs && motion_.time >= grip_.until) {
    grip_.runs = false;
    current_ = hold_current_;
  }
}

void Hand::command_plant() {
  std::array<HandPlant::Drive, kAxes> drives;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double speed = grip_.runs ? options_.speed_limit[i] : std::abs(speed_[i]);
    drives[i] = {powered_[i], reference_[i] * kDegree,
                 std::min(options_.speed_limit[i], speed) * kDegree, current_[i]};
  }
  options_.plant->command(drives);
}

void Hand::warm_up(double h) {
  constexpr double kRoom = 25, kPowered = 20, kPressing = 40, kTime = 600;  // degree Celsius, s
  for (std::size_t i = 0; i < temperatures_.size(); ++i) {
    double end = kRoom;
    if (i < kAxes && powered_[i]) {
      end += kPowered + kPressing * motion_.current[i] * motion_.current[i];
    }
    temperatures_[i] += h / kTime * (end - temperatures_[i]);
  }
}

void Hand::update(Time now) {
  if (is_updated_ && now > last_update_) {
    const double before = motion_.time;
    motion_ = options_.plant->advance(to_seconds(now - last_update_));
    advance_references(motion_.time - before);
    for (std::size_t i = 0; i < kAxes; ++i) look_at_axis(i);
    warm_up(motion_.time - before);
    command_plant();
  } else if (!is_updated_) {
    motion_ = options_.plant->advance(0);
    for (std::size_t i = 0; i < kAxes; ++i) {
      reference_[i] = sent_[i] = motion_.position[i] / kDegree;
    }
  }
  last_update_ = now;
  is_updated_ = true;
  if (boots_until_ && now >= *boots_until_) {
    boots_until_.reset();
    put(std::string("SDH2\r\n@boot complete\r\n"),
        now);  // stored start-up text; its words are ours
  }
  while (!outputs_.empty() && outputs_.front().due <= now) {
    if (!is_mute_) send_(outputs_.front().bytes);
    outputs_.pop_front();
  }
}

}  // namespace prehend::drivers::sdh
