#include "drivers/sdh/driver/driver.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace prehend::drivers::sdh {
namespace {

constexpr std::string_view kFlush = " \r\n";  // ends a half-typed command (SDHLibrary-CPP)
constexpr double kDrainTime = 0.1;            // s, in which what comes is thrown away

Bytes bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// That the driver sends and reads in the binary form, where it may.
bool has_binary_form(Command command) {
  switch (command) {
    case Command::kSpeed:
    case Command::kActualSpeed:
    case Command::kActualPosition:
    case Command::kState:
    case Command::kTarget:
    case Command::kAcceleration:
    case Command::kCurrentLimit:
    case Command::kPower:
      return true;
    default:
      return false;
  }
}

bool is_whole_number(Command command) {
  return command == Command::kController || command == Command::kProfile ||
         command == Command::kPower;
}

void check(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(std::string("SDH driver: ") + what);
}

bool is_positive(double value) { return std::isfinite(value) && value > 0; }

}  // namespace

Limits sdh2_limits() {
  Limits limits;
  for (std::size_t i = 0; i < kAxes; ++i) {
    constexpr double kRange = 90;
    constexpr double kSpeeds[kAxes] = {83, 140, 200, 140, 200, 140, 200};  // deg/s
    limits.lower[i] = i == 0 ? 0 : -kRange * kDegree;
    limits.upper[i] = kRange * kDegree;
    limits.max_speed[i] = kSpeeds[i] * kDegree;
    limits.max_current[i] = 1;
  }
  return limits;
}

const char* to_string(DriverState state) {
  switch (state) {
    case DriverState::kDisconnected:
      return "disconnected";
    case DriverState::kConnecting:
      return "connecting";
    case DriverState::kLost:
      return "lost";
    case DriverState::kFault:
      return "fault";
    case DriverState::kOff:
      return "off";
    case DriverState::kStanding:
      return "standing";
    case DriverState::kMoving:
      return "moving";
    case DriverState::kHolding:
      return "holding";
  }
  return "?";
}

bool Reading::is_blocked() const {
  return std::ranges::any_of(blocked, [](bool on) { return on; });
}

Driver::Driver(const DriverOptions& options, Send send, Note note)
    : options_(options),
      send_(std::move(send)),
      note_(std::move(note)),
      decoder_(options.has_checksum) {
  for (const double value :
       {options.state_period, options.watchdog, options.loss_time, options.reply_time,
        options.stop_repeat, options.stop_time, options.start_time, options.blocked_time,
        options.tolerance, options.grip_give, options.stretch, options.temperature_period,
        options.acceleration}) {
    check(is_positive(value), "times, tolerances and the acceleration must be positive");
  }
  check(options.tries >= 1, "a command needs at least one try");
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Limits& limits = options.limits;
    check(std::isfinite(limits.lower[i]) && limits.lower[i] < limits.upper[i] &&
              std::isfinite(limits.upper[i]),
          "a lower limit must be below its upper one");
    check(is_positive(limits.max_speed[i]) && is_positive(limits.max_current[i]),
          "limits of speed and current must be positive");
  }
  max_speed_ = options.limits.max_speed;
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
                        "; nothing can be sent, so the motion goes on to its target, or where it "
                        "is blocked"
                  : why);
  has_line_ = lost_ = parks_ = powers_off_ = false;
  exchange_.reset();
  stopping_.reset();
  end_motion(why);
  reading_.blocked.fill(false);
  update_state();
}

void Driver::begin_anew(const std::string& why, Time now) {
  if (!has_line_) return;
  note_(true, why);
  end_motion(why);
  begin_connecting(now);
  update_state();
}

// `stop` comes first: whatever the hand was doing, a new connection does not go on with it.
void Driver::begin_connecting(Time now) {
  ++counters_.connections;
  end_motion("the connection began anew");
  connect_ = Connect::kStop;
  cycle_ = Cycle::kState;
  has_temperatures_ = true;
  parks_ = powers_off_ = false;
  stopping_.reset();
  reading_.states = 0;
  reading_.moving = false;
  reading_.blocked.fill(false);
  reading_.error_code = 0;
  exchange_.reset();
  connecting_since_ = last_state_ = last_temperature_ = now;
  send_(bytes_of(kFlush));
  send_(bytes_of("stop\r\n"));
  drain(now);
}

void Driver::drain(Time now) {
  decoder_.clear();
  drains_until_ = now + to_time(kDrainTime);
}

void Driver::ask(Command command, std::vector<double> values, Time now) {
  const bool is_binary = options_.binary && firmware_.has_binary() && has_binary_form(command);
  exchange_ = Exchange{command, std::move(values), is_binary, now, 1};
  transmit(*exchange_);
}

void Driver::transmit(const Exchange& exchange) {
  if (exchange.is_binary) {
    BinaryRequest request{static_cast<std::uint8_t>(exchange.command)};
    if (!exchange.values.empty()) {
      request.values.emplace();
      std::ranges::copy(exchange.values, request.values->begin());
    }
    send_(encode(request, options_.has_checksum));
    return;
  }
  const LineRequest request{.name = to_string(exchange.command), .values = exchange.values};
  send_(bytes_of(encode(request, is_whole_number(exchange.command))));
}

void Driver::ask_again(Time now) {
  ++exchange_->tries;
  exchange_->sent = now;
  transmit(*exchange_);
}

void Driver::receive(Bytes bytes, Time now) {
  if (!has_line_) return;
  if (drains_until_) {
    if (now < *drains_until_) return;
    drains_until_.reset();
  }
  decoder_.add(bytes);
  while (const auto reply = decoder_.next()) {
    std::visit([&](const auto& r) { take(r, now); }, *reply);
  }
  update_state();
}

// What was sent and not answered: the line is made clean, and it is sent again. A connection that
// gets no answer goes on asking.
void Driver::watch_exchange(Time now) {
  if (!exchange_ || now - exchange_->sent < to_time(options_.reply_time)) return;
  ++counters_.unanswered;
  const bool connects = connect_ != Connect::kDone;
  if (connects || exchange_->tries < options_.tries) {
    send_(bytes_of(kFlush));
    if (exchange_->command == Command::kStop) return ask_again(now);
    drain(now);
    // Its time counts from the end of that.
    exchange_->sent = *drains_until_ - to_time(options_.reply_time);
    ++exchange_->tries;
    return;
  }
  const Exchange given_up = *exchange_;
  exchange_.reset();
  const std::string words = std::string("no answer to ") + to_string(given_up.command);
  if (given_up.command == Command::kTemperature) return note_(true, words);
  if (given_up.command == Command::kPower) return;  // it is sent until states show it
  if (given_up.values.empty() && given_up.command != Command::kMove) return;  // loss_time tells
  note_(true, words);
  stop(now, words);  // it may have arrived nevertheless
}

void Driver::update(Time now) {
  if (!has_line_) return;
  if (drains_until_ && now >= *drains_until_) {
    drains_until_.reset();
    decoder_.clear();
    if (exchange_) {
      exchange_->sent = now;
      transmit(*exchange_);
    }
  }
  if (!drains_until_) watch_exchange(now);
  const bool is_silent = now - last_state_ > to_time(options_.loss_time);
  if (is_silent && connect_ == Connect::kDone) {
    lost_ = true;
    char words[96];
    std::snprintf(words, sizeof words,
                  "no state from the hand for %g s: stop is sent until it is answered",
                  options_.loss_time);
    note_(true, words);
    end_motion("the hand's answers were lost");
    begin_connecting(now);
  }
  watch_stop(now);
  update_motion(now);
  if (!exchange_ && !drains_until_) next_exchange(now);
  update_state();
}

void Driver::next_exchange(Time now) {
  if (connect_ != Connect::kDone) return next_of_connection(now);
  if (powers_off_ && now - power_off_sent_ > to_time(options_.stop_repeat)) {
    power_off_sent_ = now;
    return ask(Command::kPower, std::vector<double>(kAxes, 0.0), now);
  }
  if (parks_) {
    std::vector<double> here;
    for (std::size_t i = 0; i < kAxes; ++i) {
      const Limits& limits = options_.limits;
      here.push_back(std::clamp(reading_.position[i], limits.lower[i], limits.upper[i]) / kDegree);
    }
    return ask(Command::kTarget, here, now);
  }
  const auto degrees = [](const AxisValues& values) {
    std::vector<double> converted;
    for (const double value : values) converted.push_back(value / kDegree);
    return converted;
  };
  switch (setup_) {
    case Setup::kCurrent:
      return ask(Command::kCurrentLimit, {motion_.current.begin(), motion_.current.end()}, now);
    case Setup::kSpeed:
      return ask(Command::kSpeed, degrees(motion_.speed), now);
    case Setup::kTarget:
      return ask(Command::kTarget, degrees(motion_.target), now);
    case Setup::kGo:
      return ask(Command::kMove, {}, now);
    case Setup::kNone:
      return next_of_cycle(now);
  }
}

void Driver::next_of_connection(Time now) {
  switch (connect_) {
    case Connect::kStop:
      return ask(Command::kStop, {}, now);
    case Connect::kVersion:
      return ask(Command::kVersion, {}, now);
    case Connect::kSpeedLimit:
      return ask(Command::kSpeedLimit, {}, now);
    case Connect::kAccelerationLimit:
      return ask(Command::kAccelerationLimit, {}, now);
    case Connect::kController:
      return ask(Command::kController, {}, now);
    case Connect::kSetController:
      return ask(Command::kController, {0}, now);
    case Connect::kProfile:
      return ask(Command::kProfile, {options_.profile == Profile::kRamp ? 1.0 : 0.0}, now);
    case Connect::kAcceleration: {
      std::vector<double> ramps;
      for (std::size_t i = 0; i < kAxes; ++i) {
        const double most = max_acceleration_[i];
        ramps.push_back((most > 0 ? std::min(options_.acceleration, most) : options_.acceleration) /
                        kDegree);
      }
      return ask(Command::kAcceleration, ramps, now);
    }
    case Connect::kState:
      return ask(Command::kState, {}, now);
    case Connect::kPosition:
      return ask(Command::kActualPosition, {}, now);
    default:
      parks_ = true;
      connect_ = Connect::kDone;
      next_cycle_ = last_state_ = now;
      lost_ = false;
      held_ = reading_.position;
      note_(false, "the hand answers: firmware " + firmware_.text());
  }
}

void Driver::next_of_cycle(Time now) {
  if (cycle_ == Cycle::kState) {
    if (now < next_cycle_) return;
    next_cycle_ = std::max(next_cycle_ + to_time(options_.state_period), now);
  }
  switch (cycle_) {
    case Cycle::kState:
      return ask(Command::kState, {}, now);
    case Cycle::kPosition:
      return ask(Command::kActualPosition, {}, now);
    case Cycle::kVelocity:
      return ask(Command::kActualSpeed, {}, now);
    case Cycle::kTemperature:
      return ask(Command::kTemperature, {}, now);
  }
}

void Driver::update_state() {
  const bool is_off = std::ranges::all_of(
      reading_.axes, [](AxisState state) { return state == AxisState::kDisabled; });
  const bool is_unfit = std::ranges::any_of(
      reading_.axes, [](AxisState state) { return state == AxisState::kNotInitialised; });
  reading_.state = !has_line_                   ? DriverState::kDisconnected
                   : lost_                      ? DriverState::kLost
                   : connect_ != Connect::kDone ? DriverState::kConnecting
                   : reading_.states == 0       ? DriverState::kConnecting
                   : is_unfit                   ? DriverState::kFault
                   : reading_.moving            ? DriverState::kMoving
                   : reading_.is_blocked()      ? DriverState::kHolding
                   : is_off                     ? DriverState::kOff
                                                : DriverState::kStanding;
}

}  // namespace prehend::drivers::sdh
