// The emulated BH8-262's motors: what they do until their motion ends.

#include <algorithm>
#include <cmath>

#include "drivers/barrett/emulator/gcl/hand.h"

namespace prehend::drivers::barrett::gcl {
namespace {

constexpr int kGaugeRest = 128, kGaugeMost = 254, kNoGauge = 255;
constexpr double kMostCommand = 127;   // of a motor: 8 bits with a sign
constexpr double kPerSecond = 100;     // of what is by 10 ms
constexpr double kFarAway = 20;        // rad beyond any stop
constexpr double kClutchSlack = 0.03;  // rad between motor and joint: the clutch has opened

}  // namespace

double Hand::position(std::size_t motor) const {
  return (motion_.position[motor] - motors_[motor].zero) *
         options_.gearing.counts_per_radian(motor);
}

// Made of the motor's torque; what presses on the open stop is no load of the fingertip.
int Hand::strain(std::size_t motor) const {
  if (motor == kSpread || !has_gauges_) return kNoGauge;
  const double share = std::max(0.0, motion_.current[motor]) / options_.most_command;
  return static_cast<int>(std::min<double>(kGaugeRest + options_.strain_range * share, kGaugeMost));
}

bool Hand::is_moving() const {
  return std::ranges::any_of(motors_, [](const Motor& motor) {
    const bool stands = motor.task == Motor::Task::kOff || motor.task == Motor::Task::kHold ||
                        (motor.task == Motor::Task::kVelocity && motor.velocity == 0);
    return !stands;
  });
}

void Hand::begin_move(std::size_t motor, double target, bool must_arrive) {
  Motor& one = motors_[motor];
  const double here = position(motor);
  one.task = Motor::Task::kPosition;
  one.target = target;
  one.reference = one.standing_at = here;
  one.standing_since = motion_.time;
  one.velocity = one.active[target > here ? "MCV" : "MOV"] * kPerSecond;
  one.share = 1;
  one.must_arrive = must_arrive;
}

void Hand::switch_off(std::size_t motor) {
  motors_[motor].task = Motor::Task::kOff;
  motors_[motor].velocity = 0;
  if (motor == kSpread) spread_waits_ = false;
}

void Hand::hold_or_off(std::size_t motor) {
  switch_off(motor);
  if (motors_[motor].active["HOLD"] == 0) return;
  motors_[motor].task = Motor::Task::kHold;
  motors_[motor].reference = position(motor);
}

// A motor's command is K/4 times the speed that is missing (BHAPI): what it presses with when it
// stalls.
void Hand::control(const Controls& controls) {
  for (std::size_t i = 0; i < kAxes; ++i) {
    const MotorLayout& of = layout_.motors[i];
    Motor& motor = motors_[i];
    if (!of.loops || runs_on_) continue;
    const double by_10_ms = of.velocity ? controls[i].velocity * of.velocity_coefficient /
                                              static_cast<double>(options_.velocity_factor)
                                        : 0.0;
    const double gain = of.gain ? controls[i].gain : motor.active["FPG"];
    motor.task = Motor::Task::kVelocity;
    motor.velocity = by_10_ms * kPerSecond;
    motor.share = std::min(1.0, gain / 4 * std::abs(by_10_ms) / kMostCommand);
    if (of.torque && controls[i].torque != 0) {  // a pull towards a position ahead
      begin_move(i, position(i) + controls[i].torque, false);
    }
  }
}

void Hand::advance_motor(std::size_t motor, double seconds) {
  Motor& one = motors_[motor];
  if (one.task != Motor::Task::kPosition) return;
  const double way = one.target - one.reference, step = std::abs(one.velocity) * seconds;
  one.reference += std::clamp(way, -step, step);
}

// By the plant's time: a world that is held up stands still, but has not stalled.
void Hand::look_at_motor(std::size_t motor) {
  Motor& one = motors_[motor];
  const double here = position(motor), unit = options_.gearing.counts_per_radian(motor);
  const double open = motion_.position[motor] - motion_.joint[motor];
  if (motor != kSpread && open > kClutchSlack && one.active["BD"] == 0) {
    one.active["BD"] = 1;
    one.active["BP"] = static_cast<int>(std::lround((motion_.joint[motor] - one.zero) * unit));
  }
  const bool runs = one.task == Motor::Task::kPosition || one.task == Motor::Task::kInitialise;
  if (!runs) return;
  constexpr double kStill = 10;  // counts
  if (std::abs(here - one.standing_at) > kStill) {
    one.standing_at = here;
    one.standing_since = motion_.time;
  }
  const bool is_there = std::abs(one.target - here) <= one.active["MPE"];
  if (one.task == Motor::Task::kPosition && one.reference == one.target && is_there) {
    return hold_or_off(motor);
  }
  const int gauge = strain(motor);
  const bool presses = gauge != kNoGauge && gauge > one.active["HSG"];
  const double stood = motion_.time - one.standing_since;
  if (!presses && stood <= one.active["TSTOP"] * 1e-3) return;
  if (one.task == Motor::Task::kInitialise) {
    one.zero = motion_.position[motor];
    one.active["S"] = 0;
  } else if (one.must_arrive) {
    one.active["S"] |= kNotReached;
    run_error_ |= kNotReached;
  }
  hold_or_off(motor);
}

// A command that moves is answered when all its motors have ended.
void Hand::watch_run(Time now) {
  if (temperature_ >= options_.hot && state_ == State::kRunning) {
    for (std::size_t i = 0; i < kAxes; ++i) switch_off(i);
    run_error_ |= kOverTemperature;
  }
  if (state_ != State::kRunning || is_moving()) return;
  if (spread_waits_) {
    spread_waits_ = false;
    motors_[kSpread].task = Motor::Task::kInitialise;
    motors_[kSpread].standing_at = position(kSpread);
    motors_[kSpread].standing_since = motion_.time;
    return;
  }
  state_ = State::kIdle;
  answer(run_error_, {}, now);
}

void Hand::command_plant() {
  std::array<HandPlant::Drive, kAxes> drives;
  for (std::size_t i = 0; i < kAxes; ++i) {
    Motor& motor = motors_[i];
    const double unit = options_.gearing.counts_per_radian(i);
    HandPlant::Drive& drive = drives[i];
    drive.self_locking = i != kSpread;  // worm gears
    drive.current = options_.most_command * motor.share;
    drive.position = motion_.position[i];
    switch (motor.task) {
      case Motor::Task::kOff:
        break;
      case Motor::Task::kHold:
        drive.powered = true;
        drive.current = options_.most_command;
        drive.position = motor.zero + motor.reference / unit;
        drive.speed = motor.active["MCV"] * kPerSecond / unit;
        break;
      case Motor::Task::kVelocity:
        // At rest its command is zero: the gear alone holds a finger, and nothing the spread.
        drive.powered = motor.velocity != 0;
        drive.position += std::copysign(kFarAway, motor.velocity);
        drive.speed = std::abs(motor.velocity) / unit;
        break;
      case Motor::Task::kPosition:
        drive.powered = true;
        drive.position = motor.zero + motor.reference / unit;
        drive.speed = std::abs(motor.velocity) / unit;
        break;
      case Motor::Task::kInitialise:
        drive.powered = true;
        drive.position -= kFarAway;
        drive.current = options_.most_command;
        drive.speed = motor.active["IVEL"] * kPerSecond / unit;
        break;
    }
  }
  options_.plant->command(drives);
}

}  // namespace prehend::drivers::barrett::gcl
