#include "drivers/kuka_rsi/driver/driver.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace prehend::drivers::kuka_rsi {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kSameProgram = 2e-5;  // rad; four decimals of a degree are 2e-6
constexpr double kSamePlace = 0.01;    // rad, of an arm that holds what was sent last
constexpr int kOffPathCycles = 3;
constexpr int kCalmCycles = 100;
constexpr double kLeastPace = 0.6;         // of the cycle, between telegrams at the beginning
constexpr std::uint64_t kEarlyCycles = 5;  // by which time stamps may be ahead of this machine

Axes to_radians(const Axes& degrees) {
  Axes radians{};
  for (std::size_t i = 0; i < kAxes; ++i) radians[i] = degrees[i] * kDegree;
  return radians;
}

double largest_difference(const Axes& a, const Axes& b) {
  double most = 0;
  for (std::size_t i = 0; i < kAxes; ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

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

const char* to_string(State state) {
  switch (state) {
    case State::kSilent:
      return "silent";
    case State::kRefused:
      return "refused";
    case State::kBeginning:
      return "beginning";
    case State::kHolding:
      return "holding";
    case State::kMoving:
      return "moving";
    case State::kStopping:
      return "stopping";
  }
  return "?";
}

const char* to_string(Reason reason) {
  switch (reason) {
    case Reason::kNone:
      return "";
    case Reason::kAsked:
      return "stopped before the goal";
    case Reason::kLatched:
      return "stopped by /arm/fast_stop; to be acknowledged";
    case Reason::kContact:
      return "stopped by contact";
    case Reason::kNoForce:
      return "stopped: contact was to be minded, and /wrench is silent";
    case Reason::kLate:
      return "stopped: the controller missed too many answers";
    case Reason::kLost:
      return "the controller sends no more: RSI has ended, or the network";
    case Reason::kOffPath:
      return "off the path";
    case Reason::kNotThere:
      return "the goal was not reached";
    case Reason::kLimit:
      return "stopped: a set point broke a limit";
    case Reason::kNoSignals:
      return "its telegrams lack the actual axes or Delay";
    case Reason::kCorrected:
      return "actual and programmed axes differ at the start";
    case Reason::kMidway:
      return "RSI runs already, and what it was sent before is not known";
    case Reason::kCycle:
      return "its telegrams come faster than the cycle that the driver was given";
  }
  return "?";
}

Driver::Driver(const DriverOptions& options, Limits limits)
    : options_(options), limits_(std::move(limits)) {
  const auto positive = [](double value, const char* name) {
    if (value > 0 && std::isfinite(value)) return;
    throw std::invalid_argument(std::string("kuka_rsi: ") + name + " must be positive and finite");
  };
  if (options.cycle != 0.012 && options.cycle != 0.004) {
    throw std::invalid_argument("kuka_rsi: cycle must be 0.012 or 0.004 s, as the controller has");
  }
  positive(options.late_limit, "late_limit");
  positive(options.loss_cycles, "loss_cycles");
  positive(options.start_tolerance, "start_tolerance");
  positive(options.lag, "lag");
  positive(options.settled, "settled");
  positive(options.settle_time, "settle_time");
  positive(options.force_age, "force_age");
  const double cycles = std::ceil(options.lag / options.cycle);
  if (cycles > static_cast<double>(kMostLag)) {
    throw std::invalid_argument("kuka_rsi: lag is more than 512 cycles");
  }
  trail_size_ = static_cast<std::size_t>(cycles);
  if (options.loss_cycles <= static_cast<int>(kFreshDelay)) {
    throw std::invalid_argument("kuka_rsi: loss_cycles must be at least 4");
  }
}

std::string_view Driver::on_packet(std::string_view text, Time now) {
  RobotTelegram telegram;
  const char* why = "";
  const TelegramResult result = read_robot_telegram(text, options_.names, telegram, why);
  if (result == TelegramResult::kShort) return {};
  if (result == TelegramResult::kWrong) {
    ++now_.damaged;
    return {};
  }
  ++now_.telegrams;
  const bool begins = now_.state == State::kSilent || now_.state == State::kRefused;
  if (!telegram.actual_axes || !telegram.delay) {
    if (begins) return last_telegram_ = now, refuse(Reason::kNoSignals);
    ++now_.damaged;
    return {};
  }
  return begins ? begin(telegram, now) : go_on(telegram, now);
}

std::string_view Driver::refuse(Reason reason) {
  // Unanswered because of its cycle, RSI is met under way from then on.
  const bool is_sequel =
      now_.state == State::kRefused && now_.refusal == Reason::kCycle && reason == Reason::kMidway;
  now_.state = State::kRefused;
  if (!is_sequel) now_.refusal = reason;
  answered_ = false;
  return {};
}

// One damaged telegram must not begin anything, so two have to agree; one, where two of its own
// parts do.
std::string_view Driver::begin(const RobotTelegram& telegram, Time now) {
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

std::string_view Driver::go_on(const RobotTelegram& telegram, Time now) {
  const Flow flow = flow_of(telegram, now);
  if (!flow.believed) {
    ++(flow.repeated ? now_.repeated : now_.damaged);
    return {};
  }
  if (step_ == 0) {
    const auto cycle = static_cast<std::uint64_t>(std::llround(options_.cycle * 1e3));
    const std::uint64_t way = telegram.ipoc.value - last_ipoc_.value;
    // Stamps are in ms: a set point a telegram would be a motion three times too fast.
    if (way == 4 && cycle == 12) return last_telegram_ = now, refuse(Reason::kCycle);
    step_ = way % cycle == 0 ? cycle : 1;
  }
  last_telegram_ = now;
  take_state(telegram);
  count(flow);
  if (flow.accepted) {
    for (std::size_t i = 0; i < kAxes; ++i) {
      velocity_[i] = (pending_[i] - now_.set_point[i]) / options_.cycle;
    }
    now_.set_point = pending_;
    trail_[trail_next_] = pending_;
    trail_next_ = (trail_next_ + 1) % trail_size_;
  }
  if (now_.state == State::kBeginning) {
    const bool is_there = largest_difference(now_.actual, pending_) <= kSamePlace;
    begun_ = is_there ? begun_ + 1 : 0;
    if (begun_ == 0) begun_time_ = now;
    if (begun_ >= kBeginTelegrams) {
      const double pace = to_seconds(now - begun_time_) / begun_;
      if (pace < kLeastPace * options_.cycle) return refuse(Reason::kCycle);
      now_.state = State::kHolding;
    }
  }
  mind_force(now);
  watch_path();
  const auto most = static_cast<std::uint64_t>(options_.late_limit);
  if (trouble_ >= options_.late_limit) end_motion(Reason::kLate);
  if (unaccepted_ >= most) {
    stand();  // it does so since the last answer that was accepted
  } else if (flow.accepted) {
    advance();
  }
  return answer(telegram);
}

std::string_view Driver::answer(const RobotTelegram& telegram) {
  Axes correction{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    correction[i] = (pending_[i] - now_.reference[i]) / kDegree;
  }
  const std::size_t size = write_sensor_telegram(out_, options_.names, correction, telegram.ipoc);
  answered_ = size > 0;
  if (answered_) ++now_.answers;
  return {out_.data(), size};
}

void Driver::on_time(Time now) {
  if (now - last_telegram_ <= to_time(options_.loss_cycles * options_.cycle)) return;
  has_candidate_ = false;
  if (now_.state == State::kSilent) return;
  end_motion(Reason::kLost);
  velocity_ = {};
  now_.velocity = {};
  now_.state = State::kSilent;
  now_.refusal = Reason::kNone;
}

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
