#include "drivers/kuka_rsi/driver/driver.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "drivers/kuka_rsi/driver/axes.h"

namespace prehend::drivers::kuka_rsi {
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

std::string_view Driver::on_packet(std::string_view text, Time arrived) {
  RobotTelegram telegram;
  const char* why = "";
  const TelegramResult result = read_robot_telegram(text, options_.names, telegram, why);
  if (result == TelegramResult::kShort) return {};
  if (result == TelegramResult::kWrong) {
    ++now_.damaged;
    return {};
  }
  ++now_.telegrams;
  // Stamps come from the wall clock: a step of it is no silence, and nothing came before the last.
  arrived = std::max(arrived, last_telegram_);
  const bool begins = now_.state == State::kSilent || now_.state == State::kRefused;
  if (!telegram.actual_axes || !telegram.delay) {
    if (begins) return last_telegram_ = arrived, refuse(Reason::kNoSignals);
    ++now_.damaged;
    return {};
  }
  return begins ? begin(telegram, arrived) : go_on(telegram, arrived);
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
  if (now_.state == State::kBeginning && !begin_further(now)) return refuse(Reason::kCycle);
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

}  // namespace prehend::drivers::kuka_rsi
