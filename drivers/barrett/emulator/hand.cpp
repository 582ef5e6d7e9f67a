#include "drivers/barrett/emulator/hand.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace prehend::drivers::barrett {
namespace {

// What the pucks have after power-on (pyHand's defaults; MT and DP of the BHand API).
struct Default {
  Property property;
  std::int32_t finger, spread;
};
constexpr Default kDefaults[] = {
    {Property::kMostTemperature, 60, 60},
    {Property::kMostTorque, 2200, 2200},
    {Property::kMostVelocity, 200, 50},
    {Property::kDefaultPosition, 45000, 17975},
    {Property::kHold, 0, 1},
    {Property::kStallTime, 50, 150},
    {Property::kInitialVelocity, -75, -75},
    {Property::kAcceleration, 200, 200},
    {Property::kTactileId, 4, 4},
    {Property::kRole, 0, 0},
};
constexpr double kCloseTarget[2] = {195000, 35950};  // CT: finger, spread
constexpr double kGaugeMiddle = 2048, kGaugeMost = 4095;

std::size_t index_of(Property property) { return static_cast<std::size_t>(property); }

}  // namespace

Hand::Hand(const HandOptions& options, Send send) : options_(options), send_(std::move(send)) {
  if (options.plant == nullptr) throw std::invalid_argument("an emulated hand needs a plant");
  set_temperature(options.room);
  for (std::size_t i = 0; i < kAxes; ++i) power_on(i, {});
}

void Hand::power_on(std::size_t axis, Time now) {
  Puck& puck = pucks_[axis];
  puck.values.fill(0);
  for (const Default& one : kDefaults) {
    puck.values[index_of(one.property)] = axis == kSpread ? one.spread : one.finger;
  }
  puck.values[index_of(Property::kVersion)] = options_.firmware;
  puck.values[index_of(Property::kSerial)] = 1000 + static_cast<int>(axis);
  puck.status = options_.is_awake ? Status::kReady : Status::kMonitor;
  puck.wakes.reset();
  if (!options_.is_awake && options_.self_start > 0) {
    puck.wakes = now + to_time(options_.self_start);
  }
  puck.zero = motion_.position[axis];
  puck.mode = Mode::kIdle;
  puck.initialises = false;
  puck.reference = puck.velocity = 0;
}

void Hand::reboot(Time now) {
  for (std::size_t i = 0; i < kAxes; ++i) power_on(i, now);
  powered_at_ = now;
  command_plant();
}

void Hand::set_mute(bool mute, std::optional<std::size_t> axis) {
  if (axis) {
    pucks_.at(*axis).mute = mute;
  } else {
    is_mute_ = mute;
  }
}

void Hand::set_temperature(double celsius) {
  for (Puck& puck : pucks_) puck.motor_temperature = puck.temperature = celsius;
}

void Hand::set_error(bool on) {
  for (std::size_t i = 0; i < kAxes; ++i) {
    pucks_[i].status = on ? Status::kError : Status::kReady;
    if (on) switch_mode(i, Mode::kIdle);
  }
}

bool Hand::is_moving() const {
  return std::ranges::any_of(pucks_, [](const Puck& puck) {
    return puck.mode != Mode::kIdle && puck.mode != Mode::kPosition;
  });
}

double Hand::position(std::size_t axis) const {
  return (motion_.position[axis] - pucks_[axis].zero) * options_.gearing.counts_per_radian(axis);
}

double Hand::joint_position(std::size_t axis) const {
  return (motion_.joint[axis] - pucks_[axis].zero) * options_.gearing.joint_counts_per_radian();
}

void Hand::put(std::size_t axis, const CanFrame& frame) {
  if (!is_mute_ && !pucks_[axis].mute) send_(frame);
}

void Hand::receive(const CanFrame& frame, Time now) {
  const auto request = decode_request(frame);
  if (!request) return;
  const Puck& puck = pucks_[request->axis];
  const auto property = static_cast<Property>(request->property);
  // In monitor mode a puck is asked little, and only told to wake.
  const bool is_awake = puck.status != Status::kMonitor;
  const bool may = is_awake || property == Property::kStatus || property == Property::kVersion;
  if (!may || (puck.wakes && options_.self_start <= 0)) return;
  if (!request->value) return ask(request->axis, request->property);
  if (deaf_to_ == property) return;
  set(request->axis, request->property, *request->value, now);
}

void Hand::ask(std::size_t axis, std::uint8_t property) {
  const Puck& puck = pucks_[axis];
  std::int32_t value = puck.values[property];
  switch (static_cast<Property>(property)) {
    case Property::kPosition: {
      Position answer{axis, static_cast<std::int32_t>(std::lround(position(axis)))};
      if (options_.has_joint_encoders && axis != kSpread) {
        answer.joint = static_cast<std::int32_t>(std::lround(joint_position(axis)));
      }
      return put(axis, encode(answer));
    }
    case Property::kJointPosition:
      value = static_cast<std::int32_t>(std::lround(joint_position(axis)));
      break;
    case Property::kStatus:
      value = static_cast<int>(puck.status);
      break;
    case Property::kMode:
      value = static_cast<int>(puck.mode);
      break;
    case Property::kTemperature:
      value = static_cast<std::int32_t>(std::lround(puck.temperature));
      break;
    case Property::kThermistor:
      value = static_cast<std::int32_t>(std::lround(puck.motor_temperature));
      break;
    case Property::kUptime:
      value = static_cast<std::int32_t>(to_seconds(last_update_ - powered_at_));
      break;
    case Property::kTactileId:
      if (pads_fail_) value = kPadNotInitialised;
      break;
    case Property::kTactile:
      if (value != kTactileFull) break;
      for (const TactilePart& part : split(axis, puck.cells)) put(axis, encode(part));
      return;
    case Property::kStrain:
      // Made of the motor's torque; what presses on the open stop is no load of the fingertip.
      value = static_cast<std::int32_t>(std::min(
          kGaugeMiddle + kGaugeMiddle * std::max(0.0, motion_.current[axis]) / options_.most_torque,
          kGaugeMost));
      break;
    default:
      break;
  }
  put(axis, encode(Value{axis, property, value}));
}

void Hand::set(std::size_t axis, std::uint8_t property, std::int32_t value, Time now) {
  Puck& puck = pucks_[axis];
  switch (static_cast<Property>(property)) {
    case Property::kStatus:
      if (value != static_cast<int>(Status::kReady) || puck.status != Status::kMonitor) return;
      puck.wakes = std::min(now + to_time(options_.wake_time), puck.wakes.value_or(Time::max()));
      return;
    case Property::kMode:
      if (value < 0 || value > kLastMode) return;
      return switch_mode(axis, static_cast<Mode>(value));
    case Property::kCommand:
      return carry_out(axis, static_cast<Command>(value), now);
    case Property::kMove:
      puck.values[property] = value;
      return begin_move(axis, value);
    case Property::kPosition:  // is where a puck believes to be
      puck.zero = motion_.position[axis] - value / options_.gearing.counts_per_radian(axis);
      return;
    case Property::kTactile:
      puck.values[property] = value;
      if (value == kTactileFull && !pads_fail_) ask(axis, property);
      return;
    case Property::kVersion:
    case Property::kSerial:
    case Property::kUptime:
    case Property::kStrain:
    case Property::kTemperature:
    case Property::kThermistor:
      return;  // read only
    default:
      puck.values[property] = value;
  }
}

void Hand::switch_mode(std::size_t axis, Mode mode) {
  Puck& puck = pucks_[axis];
  stops_ += mode == Mode::kIdle;
  puck.initialises = false;
  puck.mode = mode;
  puck.reference = position(axis);
  puck.velocity = 0;
  puck.standing_at = position(axis);
  puck.standing_since = motion_.time;
  command_plant();
}

void Hand::carry_out(std::size_t axis, Command command, Time now) {
  Puck& puck = pucks_[axis];
  if (puck.status != Status::kReady) return;
  switch (command) {
    case Command::kReset:
      power_on(axis, now);
      return;
    case Command::kInitialise:
      switch_mode(axis, Mode::kVelocity);
      puck.initialises = true;
      ++moves_;
      return;
    case Command::kClose:
      return begin_move(axis, static_cast<std::int32_t>(kCloseTarget[axis == kSpread]));
    case Command::kOpen:
      return begin_move(axis, 0);
    case Command::kMove:
      return begin_move(axis, puck.values[index_of(Property::kDefaultPosition)]);
    case Command::kOff:
      return switch_mode(axis, Mode::kIdle);
  }
}

void Hand::begin_move(std::size_t axis, std::int32_t target) {
  Puck& puck = pucks_[axis];
  if (puck.status != Status::kReady) return;
  ++moves_;
  constexpr double kAhead = 0.3;  // rad that the reference of an axis which lags may be ahead
  if (puck.mode != Mode::kTrapezoid) switch_mode(axis, Mode::kTrapezoid);
  const double room = kAhead * options_.gearing.counts_per_radian(axis), here = position(axis);
  puck.reference = std::clamp(puck.reference, here - room, here + room);
  puck.values[index_of(Property::kEnd)] = target;
  puck.standing_since = motion_.time;
  puck.standing_at = position(axis);
}

// Of the torque that MT allows, what heat leaves: none at OTEMP, all 16 degrees below.
double Hand::torque_limit(std::size_t axis) const {
  constexpr double kDerating = 16;  // degree Celsius
  const Puck& puck = pucks_[axis];
  const double most =
      std::min<double>(puck.values[index_of(Property::kMostTorque)], options_.most_torque);
  const double below = puck.values[index_of(Property::kMostTemperature)] - puck.temperature;
  return std::max(0.0, most) * std::clamp(below / kDerating, 0.0, 1.0);
}

void Hand::end_motion(std::size_t axis) {
  Puck& puck = pucks_[axis];
  const bool holds = puck.values[index_of(Property::kHold)] != 0;
  puck.initialises = false;
  puck.mode = holds ? Mode::kPosition : Mode::kIdle;
  puck.reference = position(axis);
  puck.velocity = 0;
}

void Hand::advance_axis(std::size_t axis, double h) {
  Puck& puck = pucks_[axis];
  constexpr double kPerSecond = 1e3;  // of what is by the millisecond
  if (puck.mode == Mode::kVelocity) {
    const double speed = puck.initialises ? puck.values[index_of(Property::kInitialVelocity)]
                                          : puck.values[index_of(Property::kVelocity)];
    puck.velocity = speed * kPerSecond;
    puck.reference += puck.velocity * h;
    return;
  }
  if (puck.mode != Mode::kTrapezoid) return;
  const double ramp = puck.values[index_of(Property::kAcceleration)] / 256.0 * kPerSecond *
                      kPerSecond;  // counts/s^2
  const double most = std::abs(puck.values[index_of(Property::kMostVelocity)]) * kPerSecond;
  const double way = puck.values[index_of(Property::kEnd)] - puck.reference;
  const double wanted = std::copysign(std::min(most, std::sqrt(2 * ramp * std::abs(way))), way);
  puck.velocity += std::clamp(wanted - puck.velocity, -ramp * h, ramp * h);
  puck.velocity = std::clamp(puck.velocity, -most, most);
  const double step = puck.velocity * h;
  puck.reference = std::abs(step) >= std::abs(way) && step * way >= 0
                       ? puck.values[index_of(Property::kEnd)]
                       : puck.reference + step;
}

// By the plant's time: a world that is held up stands still, but has not stalled.
void Hand::look_at_axis(std::size_t axis) {
  constexpr double kStill = 40;  // counts
  Puck& puck = pucks_[axis];
  if (puck.mode != Mode::kTrapezoid && puck.mode != Mode::kVelocity) return;
  const double here = position(axis);
  if (std::abs(here - puck.standing_at) > kStill) {
    puck.standing_at = here;
    puck.standing_since = motion_.time;
  }
  const double stood = motion_.time - puck.standing_since;
  constexpr double kSettles = 0.02;  // s
  if (puck.mode == Mode::kTrapezoid) {
    const double end = puck.values[index_of(Property::kEnd)];
    const double tolerance = options_.tolerance * options_.gearing.counts_per_radian(axis);
    const bool is_there = puck.reference == end && std::abs(end - here) <= tolerance;
    if (is_there && stood > kSettles) return end_motion(axis);
  }
  const double patience = puck.values[index_of(Property::kStallTime)] * 1e-3;
  if (patience <= 0 || stood <= patience) return;
  if (puck.initialises) puck.zero = motion_.position[axis];
  end_motion(axis);
}

void Hand::warm_up(std::size_t axis, double h) {
  constexpr double kPressing = 60, kTime = 300;  // degree Celsius at full torque, s
  Puck& puck = pucks_[axis];
  const double part = puck.mode == Mode::kIdle ? 0 : motion_.current[axis] / options_.most_torque;
  const double end = options_.room + kPressing * part * part;
  puck.motor_temperature += h / kTime * (end - puck.motor_temperature);
  puck.temperature += h / kTime * (0.5 * (end + options_.room) - puck.temperature);
}

void Hand::command_plant() {
  std::array<HandPlant::Drive, kAxes> drives;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Puck& puck = pucks_[i];
    const double unit = options_.gearing.counts_per_radian(i);
    HandPlant::Drive& drive = drives[i];
    drive.powered = puck.mode != Mode::kIdle;
    drive.position = puck.zero + puck.reference / unit;
    const int speed = puck.mode == Mode::kVelocity
                          ? puck.values[index_of(puck.initialises ? Property::kInitialVelocity
                                                                  : Property::kVelocity)]
                          : puck.values[index_of(Property::kMostVelocity)];
    drive.speed = std::abs(speed) * 1e3 / unit;
    drive.current = torque_limit(i);
    drive.self_locking = i != kSpread;  // worm gears
  }
  options_.plant->command(drives);
}

void Hand::update(Time now) {
  constexpr double kStep = 2e-3;  // s
  if (is_updated_ && now > last_update_) {
    const double before = motion_.time;
    motion_ = options_.plant->advance(to_seconds(now - last_update_));
    const double passed = motion_.time - before;
    for (std::size_t i = 0; i < kAxes; ++i) {
      for (double left = passed; left > 0; left -= kStep) advance_axis(i, std::min(left, kStep));
      look_at_axis(i);
      warm_up(i, passed);
    }
    command_plant();
  } else if (!is_updated_) {
    motion_ = options_.plant->advance(0);
    powered_at_ = now;
    for (std::size_t i = 0; i < kAxes; ++i) power_on(i, now);
  }
  last_update_ = now;
  is_updated_ = true;
  for (Puck& puck : pucks_) {
    if (!puck.wakes || now < *puck.wakes) continue;
    puck.wakes.reset();
    puck.status = Status::kReady;
  }
}

}  // namespace prehend::drivers::barrett
