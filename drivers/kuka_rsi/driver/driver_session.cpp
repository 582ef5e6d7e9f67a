// What of the driver knows RSI: how it begins, what telegrams say of those before them.

#include "drivers/kuka_rsi/driver/driver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/kuka_rsi/driver/axes.h"

namespace prehend::drivers::kuka_rsi {
namespace {

constexpr double kSameProgram = 2e-5;  // rad; four decimals of a degree are 2e-6
constexpr int kCalmCycles = 100;
constexpr double kLeastPace = 0.6;         // of the cycle, between telegrams at the beginning
constexpr std::uint64_t kEarlyCycles = 5;  // by which time stamps may be ahead of this machine

}  // namespace

std::string_view Driver::refuse(Reason reason) {
  now_.state = State::kRefused;
  now_.refusal = reason;
  answered_ = false;
  return {};
}

// One damaged telegram must not begin anything, so two have to agree; one, where two of its own
// parts do.
std::string_view Driver::begin(const RobotTelegram& telegram, Time now) {
  // Of a cycle that is not the driver's, until the controller has ended RSI.
  if (now_.state == State::kRefused && now_.refusal == Reason::kCycle) {
    last_telegram_ = now;
    return {};
  }
  const auto cycle = static_cast<std::uint64_t>(std::llround(options_.cycle * 1e3));
  const Axes actual = to_radians(*telegram.actual_axes);
  const double tolerance = options_.start_tolerance;
  const bool at_program =
      telegram.commanded_axes &&
      largest_difference(actual, to_radians(*telegram.commanded_axes)) <= tolerance;
  const RobotTelegram before = std::exchange(candidate_, telegram);
  const bool had_candidate = std::exchange(has_candidate_, true);
  const std::uint64_t way = telegram.ipoc.value - before.ipoc.value;
  const bool confirmed = had_candidate && (way == 1 || way == cycle) &&
                         *telegram.delay - *before.delay <= 1 &&
                         largest_difference(actual, to_radians(*before.actual_axes)) <= tolerance;
  last_telegram_ = now;
  if (!confirmed && !(at_program && *telegram.delay == 0)) return {};
  if (*telegram.delay <= kFreshDelay) {
    if (telegram.commanded_axes && !at_program) return refuse(Reason::kCorrected);
    now_.reference = telegram.commanded_axes ? to_radians(*telegram.commanded_axes) : actual;
    now_.set_point = pending_ = now_.reference;
    ++now_.sessions;
  } else if (is_same_session(telegram, actual)) {
    now_.set_point = pending_;
  } else {
    return refuse(Reason::kMidway);
  }
  now_.state = State::kBeginning;
  now_.refusal = Reason::kNone;
  has_session_ = true;
  has_candidate_ = false;
  step_ = confirmed ? way : 0;
  velocity_ = {};
  begun_ = trouble_ = calm_ = 0;
  begun_time_ = now;
  unaccepted_ = 0;
  delay_before_ = *telegram.delay;
  now_.actual = actual;
  take_state(telegram);
  forget_trail();
  return answer(telegram);
}

// Those that waited somewhere on their way come at once, and a few of them look like a short cycle;
// a short cycle stays one however many are counted.
bool Driver::begin_further(Time now) {
  const bool is_there = largest_difference(now_.actual, pending_) <= kSamePlace;
  begun_ = is_there ? begun_ + 1 : 0;
  if (begun_ == 0) begun_time_ = now;
  if (begun_ < kBeginTelegrams) return true;
  const double pace = to_seconds(now - begun_time_) / begun_;
  if (pace < kLeastPace * options_.cycle) return begun_ < kFastTelegrams;
  now_.state = State::kHolding;
  return true;
}

bool Driver::is_same_session(const RobotTelegram& telegram, const Axes& actual) const {
  return has_session_ && telegram.commanded_axes && telegram.ipoc.value > last_ipoc_.value &&
         *telegram.delay >= now_.delay &&
         largest_difference(to_radians(*telegram.commanded_axes), now_.reference) <= kSameProgram &&
         largest_difference(actual, pending_) <= kSamePlace;
}

void Driver::take_state(const RobotTelegram& telegram) {
  const Axes actual = to_radians(*telegram.actual_axes);
  for (std::size_t i = 0; i < kAxes; ++i) {
    now_.velocity[i] = (actual[i] - now_.actual[i]) / options_.cycle;
  }
  now_.actual = actual;
  now_.has_pose = telegram.actual_pose.has_value();
  if (now_.has_pose) now_.pose = *telegram.actual_pose;
  delay_before_ = now_.state == State::kBeginning && begun_ == 0 ? *telegram.delay : now_.delay;
  now_.delay = *telegram.delay;
  last_ipoc_ = telegram.ipoc;
}

Driver::Flow Driver::flow_of(const RobotTelegram& telegram, Time now) const {
  Flow flow;
  flow.repeated = telegram.ipoc.value <= last_ipoc_.value;
  if (flow.repeated) return flow;
  const std::uint64_t way = telegram.ipoc.value - last_ipoc_.value;
  const auto cycle = static_cast<std::uint64_t>(std::llround(options_.cycle * 1e3));
  const std::uint64_t step = step_ > 0 ? step_ : way % cycle == 0 ? cycle : 1;
  const auto cycles =
      static_cast<std::uint64_t>(to_seconds(now - last_telegram_) / options_.cycle) + kEarlyCycles;
  const std::uint64_t telegrams = way / step;
  if (way % step != 0 || telegrams > cycles) return flow;
  // A Delay that falls by one is that of before, where the last one was damaged.
  const std::uint64_t delay = *telegram.delay;
  const std::uint64_t base = delay < now_.delay ? delay_before_ : now_.delay;
  if (delay < base || delay - base > telegrams + (base < now_.delay ? 1 : 0)) return flow;
  flow.believed = true;
  flow.gap = telegrams - 1;
  const std::uint64_t silent = flow.gap + (answered_ ? 0 : 1);
  flow.late = delay - base > silent ? delay - base - silent : 0;
  flow.accepted = answered_ && flow.late == 0;
  return flow;
}

void Driver::count(const Flow& flow) {
  now_.missing += flow.gap;
  now_.late += flow.late;
  unaccepted_ = flow.accepted ? flow.gap : unaccepted_ + flow.gap + 1;
  const std::uint64_t lost = flow.gap + (flow.accepted ? 0 : 1);
  trouble_ =
      static_cast<int>(std::min<std::uint64_t>(static_cast<std::uint64_t>(trouble_) + lost,
                                               static_cast<std::uint64_t>(options_.late_limit)));
  if (lost > 0) {
    calm_ = 0;
  } else if (++calm_ >= kCalmCycles) {
    calm_ = 0;
    trouble_ = std::max(0, trouble_ - 1);
  }
}

}  // namespace prehend::drivers::kuka_rsi
