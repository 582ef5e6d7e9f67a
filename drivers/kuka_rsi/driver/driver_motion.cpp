// What of the driver moves the arm: the motion that runs, its end, braking.

#include "drivers/kuka_rsi/driver/driver.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace prehend::drivers::kuka_rsi {
namespace {

constexpr int kOffPathCycles = 3;

Snapshot::End end_of(Reason reason) {
  switch (reason) {
    case Reason::kContact:
      return Snapshot::End::kContact;
    case Reason::kOffPath:
    case Reason::kNotThere:
      return Snapshot::End::kOffPath;
    default:
      return Snapshot::End::kStopped;
  }
}

}  // namespace

std::unique_ptr<Motion> Driver::start(std::unique_ptr<Motion> motion) {
  const bool starts =
      now_.state == State::kHolding && !now_.latched && motion && !motion->set_points.empty();
  if (!starts) return motion;
  now_.ticket = motion->ticket;
  now_.end = Snapshot::End::kRunning;
  now_.reason = Reason::kNone;
  now_.broken = {};
  now_.off = now_.time = now_.largest_error = 0;
  next_ = 0;
  settling_ = off_path_ = trouble_ = 0;
  now_.state = State::kMoving;
  return std::exchange(motion_, std::move(motion));
}

void Driver::latch() {
  now_.latched = true;
  end_motion(Reason::kLatched);
}

void Driver::end_motion(Reason reason) {
  if (now_.state != State::kMoving) return;
  now_.end = end_of(reason);
  now_.reason = reason;
  now_.state = State::kStopping;
}

void Driver::stand() {
  pending_ = now_.set_point;
  velocity_ = {};
  if (now_.state == State::kStopping) now_.state = State::kHolding;
}

void Driver::mind_force(Time now) {
  if (now_.state != State::kMoving || !(motion_->contact_force > 0)) return;
  if (force_time_ == Time::min() || now - force_time_ > to_time(options_.force_age)) {
    end_motion(Reason::kNoForce);
  } else if (!(force_ <= motion_->contact_force)) {
    end_motion(Reason::kContact);
  }
}

void Driver::advance() {
  pending_ = now_.set_point;
  if (now_.state == State::kMoving) {
    next_ < motion_->set_points.size() ? follow() : settle();
  }
  if (now_.state == State::kStopping) brake();
}

void Driver::follow() {
  const Axes& next = motion_->set_points[next_];
  now_.broken = limits_.check(now_.reference, now_.set_point, velocity_, next, options_.cycle);
  if (now_.broken) return end_motion(Reason::kLimit);
  pending_ = next;
  ++next_;
  now_.time = static_cast<double>(next_) * options_.cycle;
}

void Driver::settle() {
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double off = std::abs(now_.actual[i] - now_.set_point[i]);
    if (off <= options_.settled) continue;
    if (++settling_ * options_.cycle <= options_.settle_time) return;
    now_.off = off;
    now_.broken.axis = i;
    return end_motion(Reason::kNotThere);
  }
  now_.end = Snapshot::End::kReached;
  now_.state = State::kHolding;
}

void Driver::brake() {
  limits_.brake(pending_, velocity_, options_.cycle);
  const bool stands =
      std::all_of(velocity_.begin(), velocity_.end(), [](double v) { return v == 0; });
  if (stands) now_.state = State::kHolding;
}

void Driver::forget_trail() {
  std::fill(trail_.begin(), trail_.end(), pending_);
  trail_next_ = 0;
}

// Off the path is what is outside of all that the arm was told within its lag.
void Driver::watch_path() {
  if (now_.state != State::kMoving) return;
  double worst = -1;
  std::size_t axis = 0;
  for (std::size_t i = 0; i < kAxes; ++i) {
    double lowest = now_.set_point[i], highest = now_.set_point[i];
    for (std::size_t k = 0; k < trail_size_; ++k) {
      lowest = std::min(lowest, trail_[k][i]);
      highest = std::max(highest, trail_[k][i]);
    }
    const double off = std::max({0.0, lowest - now_.actual[i], now_.actual[i] - highest});
    now_.largest_error = std::max(now_.largest_error, off);
    if (off > motion_->tolerance[i] && off > worst) worst = off, axis = i;
  }
  off_path_ = worst >= 0 ? off_path_ + 1 : 0;
  if (off_path_ < kOffPathCycles) return;
  now_.off = worst;
  now_.broken.axis = axis;
  end_motion(Reason::kOffPath);
}

}  // namespace prehend::drivers::kuka_rsi
