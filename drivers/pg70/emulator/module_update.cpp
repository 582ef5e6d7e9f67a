#include <cmath>

#include "drivers/pg70/emulator/module.h"

namespace prehend::drivers::pg70 {
namespace {

constexpr double kStandingSpeed = 2e-4;     // m/s
constexpr double kReachedTolerance = 5e-5;  // m
using Drive = GripperPlant::Drive;

}  // namespace

void Module::update(Time now) {
  if (is_updated_ && now > last_update_) motion_ = plant_.advance(to_seconds(now - last_update_));
  last_update_ = now;
  is_updated_ = true;
  if (boots_until_) {
    if (now < *boots_until_) return;
    boots_until_.reset();
    say(Info{static_cast<std::uint16_t>(InfoCode::kBoot)});
  }
  update_motion();
  update_faults(now);
  if (period_ > Time{} && now >= next_state_) {
    next_state_ += period_;
    if (next_state_ < now) next_state_ = now + period_;  // a late update is no burst
    tell_state();
  }
}

// By the plant's time: a world that is held up stands still, but is not blocked.
void Module::update_motion() {
  if (!moving_) return;
  const bool is_position = moved_by_ != Command::kMoveVelocity &&
                           moved_by_ != Command::kMoveCurrent && moved_by_ != Command::kMoveGrip;
  const bool stands = std::abs(motion_.velocity) < kStandingSpeed;
  if (!stands) standing_since_ = motion_.time;
  const bool is_there = is_position && std::abs(motion_.opening - target_) < kReachedTolerance;
  const bool is_blocked = motion_.time - standing_since_ > options_.blocked_time;
  if (referencing_ && stands && (is_there || is_blocked)) {
    moving_ = referencing_ = false;
    referenced_ = ended_ = true;
    return impulse(MotionEnd{Command::kMoveBlocked, to_device(motion_.opening)});
  }
  if (is_there && stands) {
    moving_ = false;
    ended_ = reached_ = true;
    impulse(MotionEnd{Command::kPositionReached, to_device(motion_.opening)});
  } else if (is_blocked) {
    moving_ = false;  // the plant keeps pressing
    ended_ = true;
    impulse(MotionEnd{Command::kMoveBlocked, to_device(motion_.opening)});
  }
}

void Module::update_faults(Time now) {
  // Over a soft limit: a fault, then (acknowledged) a warning until it is back inside.
  constexpr double kMargin = 5e-4;  // m
  const bool is_low = motion_.opening < -kMargin;
  const bool is_high = motion_.opening > options_.max_opening + kMargin;
  if (referenced_ && (is_low || is_high) && error_ == ErrorCode::kNone) {
    return fail(is_low ? ErrorCode::kSoftLow : ErrorCode::kSoftHigh, true, now);
  }
  if (warning_ && (error_ == ErrorCode::kSoftLow || error_ == ErrorCode::kSoftHigh) && !is_low &&
      !is_high) {
    return mend(now);
  }
  if (error_ == ErrorCode::kNone) return;
  const double period = warning_ ? options_.warning_period : options_.fault_period;
  if (now - last_fault_told_ < to_time(period)) return;
  last_fault_told_ = now;
  say(Fault{warning_ ? Command::kWarning : Command::kError, error_});
}

void Module::fail(ErrorCode code, bool persists, Time now) {
  error_ = code;
  persists_ = persists;
  warning_ = false;
  brake_ = true;
  halt(Drive::kOff);
  last_fault_told_ = now;
  say(Fault{Command::kError, code});
}

void Module::mend(Time now) {
  persists_ = false;
  if (!warning_) return;
  warning_ = false;
  error_ = ErrorCode::kNone;
  last_fault_told_ = now;
  say(Info{static_cast<std::uint16_t>(InfoCode::kNoError)});
}

void Module::acknowledge(Time now) {
  say(Confirmation{Command::kAcknowledge});
  brake_ = false;
  if (error_ != ErrorCode::kNone && persists_) {
    warning_ = true;
    last_fault_told_ = now;
    return say(Fault{Command::kWarning, error_});
  }
  error_ = ErrorCode::kNone;
  warning_ = false;
  say(Info{static_cast<std::uint16_t>(InfoCode::kNoError)});
}

void Module::reboot(Time now) {
  halt(Drive::kOff);
  boots_until_ = now + to_time(options_.boot_time);
  error_ = ErrorCode::kNone;
  persists_ = warning_ = ended_ = reached_ = brake_ = false;
  referenced_ = options_.referenced;
  impulse_on_ = options_.impulse_messages;
  speed_ = 0.1 * options_.max_speed;
  acceleration_ = 0.1 * options_.max_acceleration;
  current_ = options_.nominal_current;
  mode_ = 0;
  period_ = {};
}

State Module::state() const {
  State state;
  if (mode_ & kWithPosition) state.position = to_device(motion_.opening);
  if (mode_ & kWithVelocity) state.velocity = to_device(motion_.velocity);
  if (mode_ & kWithCurrent) state.current = static_cast<float>(motion_.current);
  const bool is_error = error_ != ErrorCode::kNone;
  state.status = static_cast<std::uint8_t>(
      (referenced_ ? kReferenced : 0) | (moving_ ? kMoving : 0) |
      (is_error && warning_ ? kWarningPresent : 0) | (is_error && !warning_ ? kErrorPresent : 0) |
      (brake_ ? kBrakeApplied : 0) | (ended_ ? kMoveEnded : 0) |
      (reached_ ? kPositionWasReached : 0));
  state.error = static_cast<std::uint8_t>(error_);
  return state;
}

void Module::tell_state() { say(state()); }

}  // namespace prehend::drivers::pg70
