#include "drivers/barrett/driver/driver.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace prehend::drivers::barrett {
namespace {

void check(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(std::string("BarrettHand driver: ") + what);
}

bool is_positive(double value) { return std::isfinite(value) && value > 0; }

}  // namespace

Limits bh8_limits(const Gearing& gearing) {
  constexpr double kFinger = 140 * M_PI / 180;  // rad
  constexpr double kMillisecond = 1e-3;         // s
  Limits limits;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const bool is_spread = i == kSpread;
    limits.upper[i] = is_spread ? M_PI : kFinger;
    limits.max_speed[i] = (is_spread ? 50 : 200) / kMillisecond / gearing.counts_per_radian(i);
    limits.max_current[i] = 2200;
  }
  return limits;
}

Driver::Driver(const DriverOptions& options, Send send, Note note, OnPad on_pad)
    : options_(options),
      send_(std::move(send)),
      note_(std::move(note)),
      on_pad_(std::move(on_pad)),
      is_initialised_(options.initialisation == Initialisation::kDone),
      begins_by_initialising_(options.initialisation == Initialisation::kAtStart) {
  for (const double value :
       {options.state_period, options.watchdog, options.loss_time, options.reply_time,
        options.stop_repeat, options.stop_time, options.begin_time, options.stall_time,
        options.tolerance, options.clutch_tolerance, options.grip_give, options.stretch,
        options.initialise_time, options.initial_velocity, options.temperature_period,
        options.gauge_range, options.gearing.finger, options.gearing.encoder,
        options.gearing.spread}) {
    check(is_positive(value), "times, tolerances, speeds and gears must be positive");
  }
  check(std::isfinite(options.tactile_period) && options.tactile_period >= 0,
        "the time between images must not be negative");
  check(options.tries >= 1, "an order needs at least one try");
  constexpr double kMostWord = 32767;
  check(options.stall_time * 1e3 <= kMostWord, "TSTOP has 16 bits of milliseconds");
  check_limits(options.limits);
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Limits& limits = options.limits;
    check(std::abs(limits.upper[i]) * options.gearing.counts_per_radian(i) < kMostPosition &&
              std::abs(limits.lower[i]) * options.gearing.counts_per_radian(i) < kMostPosition,
          "a limit is beyond the 22 bits of a position");
    check(limits.max_current[i] <= kMostWord, "MT has 16 bits");
  }
}

std::int32_t Driver::counts(std::size_t axis, double angle) const {
  return static_cast<std::int32_t>(std::lround(angle * options_.gearing.counts_per_radian(axis)));
}

std::uint64_t Driver::broken_images() const {
  std::uint64_t sum = 0;
  for (const Puck& puck : pucks_) sum += puck.pad.broken();
  return sum;
}

std::string Driver::axis_words(std::size_t axis) const {
  constexpr const char* kWords[kLastMode + 1] = {"idle",     "duty cycle", "torque",
                                                 "position", "velocity",   "trapezoid"};
  const auto mode = std::min<std::size_t>(static_cast<std::size_t>(modes_[axis]), kLastMode);
  return std::string(kWords[mode]) + (reading_.clutch_open[axis] ? ", clutch open" : "");
}

bool Driver::all_connected() const {
  return std::ranges::all_of(pucks_, [](const Puck& puck) { return puck.is_connected; });
}

void Driver::connected(Time now) {
  has_line_ = true;
  begin_connecting(now);
  update_state();
}

void Driver::disconnected(const std::string& why) {
  if (!has_line_) return;
  note_(true, reading_.moving
                  ? why +
                        "; nothing can be sent, so the motion goes on to its target, or until it "
                        "stalls"
                  : why);
  has_line_ = lost_ = is_connected_ = false;
  end_motion(why);
  stopping_.reset();
  reading_.blocked.fill(false);
  reading_.moving = false;
  update_state();
}

void Driver::begin_anew(const std::string& why, Time now) {
  if (!has_line_) return;
  note_(true, why);
  end_motion(why);
  begin_connecting(now);
  update_state();
}

// MODE 0 comes first: whatever the hand was doing, a new connection does not go on with it.
void Driver::begin_connecting(Time now) {
  ++counters_.connections;
  end_motion("the connection began anew");
  stopping_.reset();
  is_connected_ = false;
  reading_.states = 0;
  reading_.moving = false;
  reading_.blocked.fill(false);
  for (std::size_t i = 0; i < kAxes; ++i) {
    Puck& puck = pucks_[i];
    puck.steps.clear();
    puck.asked.reset();
    puck.is_connected = puck.stop_answered = puck.was_asleep = puck.is_status_bad = false;
    puck.fresh_position = puck.fresh_mode = false;
    puck.samples.clear();
    puck.last_position = puck.last_mode = puck.last_temperature = now;
    order(i, Property::kMode, static_cast<int>(Mode::kIdle));
    puck.steps.push_back({Property::kStatus, {}, Step::Kind::kConnection});
  }
}

void Driver::order(std::size_t axis, Property property, std::int32_t value) {
  send_(encode(Request{axis, static_cast<std::uint8_t>(property), value}));
}

void Driver::ask(std::size_t axis, Step step, Time now) {
  step.tries = 1;
  step.began = step.sent = now;
  pucks_[axis].asked = step;
  transmit(axis);
}

void Driver::transmit(std::size_t axis) {
  const Step& step = *pucks_[axis].asked;
  // Whatever else is asked of a puck that has not answered a stop, it is told to stop again.
  if (!pucks_[axis].stop_answered) order(axis, Property::kMode, static_cast<int>(Mode::kIdle));
  if (step.value) order(axis, step.property, *step.value);
  send_(encode(Request{axis, static_cast<std::uint8_t>(step.property)}));
}

void Driver::receive(const CanFrame& frame, Time now) {
  if (!has_line_) return;
  if (const auto reply = decode_reply(frame)) {
    std::visit([&](const auto& r) { take(r, now); }, *reply);
    update_state();
  } else {
    ++counters_.strange;
  }
}

void Driver::update(Time now) {
  if (!has_line_) return;
  for (std::size_t i = 0; i < kAxes; ++i) watch_exchange(i, now);
  watch_loss(now);
  watch_stop(now);
  update_motion(now);
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!pucks_[i].asked) next_of_puck(i, now);
  }
  ask_pads(now);
  update_state();
}

// What was sent and not answered is sent again. A connection and a stop go on until it is.
void Driver::watch_exchange(std::size_t axis, Time now) {
  Puck& puck = pucks_[axis];
  if (!puck.asked) return;
  Step& step = *puck.asked;
  const bool is_stop = step.kind == Step::Kind::kStop;
  // Each wait is twice as long as the one before: late answers must not make a bus that is slow
  // slower.
  constexpr int kMostDoublings = 3;
  const double patience =
      is_stop ? options_.stop_repeat
              : std::ldexp(options_.reply_time, std::min(step.tries - 1, kMostDoublings));
  if (now - step.sent < to_time(patience)) return;
  ++counters_.unanswered;
  // Positions and modes are asked for until they come, or loss_time is over: were the next question
  // asked instead, answers that are late would be taken for none of its.
  const bool is_state = step.kind == Step::Kind::kReading &&
                        (step.property == Property::kPosition || step.property == Property::kMode);
  const bool goes_on = is_stop || is_state || step.kind == Step::Kind::kConnection;
  if (!goes_on && step.tries >= options_.tries) {
    const Step given_up = step;
    puck.asked.reset();
    return give_up(axis, given_up, now);
  }
  ++step.tries;
  step.sent = now;
  if (is_stop && stopping_ && stopping_->moved && step.tries > options_.tries) {
    if (!stopping_->is_off) {
      stopping_->is_off = true;
      note_(true, std::string("stop of ") + axis_name(axis) +
                      " is not answered: its motor is told to switch off, too");
    }
    order(axis, Property::kCommand, static_cast<int>(Command::kOff));
  }
  transmit(axis);
}

void Driver::give_up(std::size_t axis, const Step& step, Time now) {
  if (step.kind == Step::Kind::kOptional) return puck_goes_on(axis, now);
  if (step.kind != Step::Kind::kMotion) return;  // loss_time tells
  const std::string words =
      std::string("the hand does not take ") + to_string(step.property) + " of " + axis_name(axis);
  note_(true, words);
  stop(now, words);  // it may have arrived nevertheless
}

void Driver::next_of_puck(std::size_t axis, Time now) {
  Puck& puck = pucks_[axis];
  if (puck.steps.empty() && puck.is_connected && now >= puck.next_cycle) add_readings(axis, now);
  if (puck.steps.empty()) return;
  const Step step = puck.steps.front();
  puck.steps.pop_front();
  ask(axis, step, now);
}

void Driver::add_readings(std::size_t axis, Time now) {
  constexpr int kPerGauge = 2, kPerStatus = 5, kPerUptime = 10;  // rounds
  Puck& puck = pucks_[axis];
  puck.next_cycle = std::max(puck.next_cycle + to_time(options_.state_period), now);
  ++puck.turn;
  puck.steps.push_back({Property::kPosition});
  puck.steps.push_back({Property::kMode});
  if (puck.turn % kPerGauge == 0 && axis != kSpread) puck.steps.push_back({Property::kStrain});
  if (puck.turn % kPerStatus == 0) puck.steps.push_back({Property::kStatus});
  if (puck.turn % kPerUptime == 0) puck.steps.push_back({Property::kUptime});
  if (now - puck.last_temperature < to_time(options_.temperature_period)) return;
  puck.last_temperature = now;
  puck.steps.push_back({Property::kTemperature});
  puck.steps.push_back({Property::kThermistor});
}

void Driver::watch_loss(Time now) {
  if (!is_connected_) return;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Time heard = std::min(pucks_[i].last_position, pucks_[i].last_mode);
    if (now - heard <= to_time(options_.loss_time)) continue;
    lost_ = true;
    char words[112];
    std::snprintf(words, sizeof words,
                  "no state of %s for %g s: MODE 0 is sent to all until each puck answers it",
                  axis_name(i), options_.loss_time);
    note_(true, words);
    end_motion("the hand's answers were lost");
    return begin_connecting(now);
  }
}

void Driver::ask_pads(Time now) {
  if (!is_connected_ || options_.tactile_period <= 0 || now < next_pads_) return;
  next_pads_ = std::max(next_pads_ + to_time(options_.tactile_period), now);
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Puck& puck = pucks_[i];
    const bool is_late = puck.asked && puck.asked->tries > 1;
    if (!is_late) order(i, Property::kTactile, kTactileFull);
  }
}

void Driver::update_state() {
  const bool is_unfit =
      std::ranges::any_of(pucks_, [](const Puck& puck) { return puck.is_status_bad; });
  for (std::size_t i = 0; i < kAxes; ++i) {
    reading_.answers[i] = has_line_ && pucks_[i].is_connected;
  }
  const bool initialises = !motion_.ended && motion_.initialises();
  reading_.state = !has_line_                               ? DriverState::kDisconnected
                   : lost_                                  ? DriverState::kLost
                   : !is_connected_ || reading_.states == 0 ? DriverState::kConnecting
                   : is_unfit                               ? DriverState::kFault
                   : initialises                            ? DriverState::kInitialising
                   : !is_initialised_                       ? DriverState::kUninitialised
                   : reading_.moving                        ? DriverState::kMoving
                   : reading_.is_blocked()                  ? DriverState::kHolding
                                                            : DriverState::kStanding;
}

}  // namespace prehend::drivers::barrett
