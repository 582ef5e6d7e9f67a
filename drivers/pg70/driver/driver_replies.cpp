#include <cmath>
#include <cstdio>

#include "drivers/pg70/driver/driver.h"

namespace prehend::drivers::pg70 {
namespace {

constexpr std::uint8_t kFirstErrorCode = 0x70;  // below are information codes

bool is_motion_command(Command command) { return most_values(command) > 0; }

}  // namespace

void Driver::receive(const Incoming& incoming, Time now) {
  if (incoming.direction == Direction::kCommand) return;
  if (!link_up_ && has_link_) connected(now);
  if (!link_up_) return;
  take(decode_response(incoming.content, kWithAll), now);
  update_state();
}

void Driver::take(const Response& response, Time now) {
  struct Taker {
    Driver& driver;
    Time now;
    void operator()(const Refusal& r) const { driver.take_refusal(r, now); }
    void operator()(const Confirmation& r) const { driver.answered(r.command, now); }
    void operator()(const MoveStarted& r) const { driver.answered(r.command, now); }
    void operator()(const State& r) const { driver.take_state(r, now); }
    void operator()(const DetailedError& r) const {
      driver.detailed_error_ = r;
      driver.answered(Command::kGetDetailedError, now);
    }
    void operator()(const MotionEnd& r) const { driver.take_motion_end(r, now); }
    void operator()(const Info& r) const { driver.take_info(r, now); }
    void operator()(const Fault& r) const { driver.take_fault(r, now); }
    void operator()(const ConfigValue& r) const { driver.take_config(r, now); }
    void operator()(const ConfigSet&) const { driver.answered(Command::kSetConfig, now); }
    void operator()(const DeviceFacts&) const { driver.answered(Command::kGetConfig, now); }
    void operator()(const ImpulseMessages&) const { driver.answered(Command::kToggleImpulse, now); }
    void operator()(const UserChanged&) const { driver.answered(Command::kChangeUser, now); }
    void operator()(const OtherResponse& r) const {
      ++driver.counters_.strange;
      driver.note_(true, "the module says something unknown: " + command_name(r.content.command()) +
                             " with " + std::to_string(r.content.size()) + " bytes");
    }
  };
  std::visit(Taker{*this, now}, response);
}

void Driver::answered(Command command, Time now) {
  std::erase_if(outstanding_, [&](const Outstanding& o) {
    return o.content.command() == static_cast<std::uint8_t>(command);
  });
  if (command == Command::kStop) {
    stop_confirmed_ = true;
    if (stopping_ && !stopping_->answered) stopping_->answered = now;
  }
  if (is_motion_command(command) && !motion_.ended && !motion_.accepted) {
    motion_.accepted = true;
    motion_.accepted_at = now;
  }
}

void Driver::take_state(const State& state, Time now) {
  if (!state.position || !std::isfinite(*state.position)) {
    ++counters_.strange;
    return ask_for_states(now);  // somebody else changed what is reported
  }
  last_state_ = now;
  ++reading_.states;
  ++counters_.states;
  status_ = state.status;
  reading_.opening = to_opening(*state.position);
  if (state.velocity && std::isfinite(*state.velocity)) {
    reading_.velocity = to_opening(*state.velocity);
  }
  if (state.current && std::isfinite(*state.current)) reading_.current = *state.current;
  reading_.referenced = state.status & kReferenced;
  // A repeated push against what blocks counts as a motion only when it moves; jaws that run do so
  // whatever the status says.
  constexpr double kMoves = 1e-3, kRuns = 5e-3;  // m/s
  fast_states_ = std::abs(reading_.velocity) > kRuns ? fast_states_ + 1 : 0;
  reading_.moving =
      fast_states_ > 1 ||
      ((state.status & kMoving) && !(motion_.is_repeat && std::abs(reading_.velocity) < kMoves));
  if (std::abs(reading_.current) >= options_.holding_current * motion_.current) pressed_ = now;
  if (lost_ && stop_confirmed_) {
    lost_ = false;
    note_(false, "the module answers again, and has stopped");
  }
  // The manual's examples show errors without the error bit, so the code counts unless the warning
  // bit says that its fault has been acknowledged.
  const bool is_warning = (state.status & kWarningPresent) && !(state.status & kErrorPresent);
  const bool is_error = !is_warning && state.error >= kFirstErrorCode;
  reading_.warning_code = is_warning ? state.error : 0;
  if (is_error) {
    fault(state.error, now);
  } else if (state.status & kErrorPresent) {
    fault(static_cast<std::uint8_t>(ErrorCode::kInternal), now);
  } else {
    reading_.error_code = 0;
    fault_told_ = false;
    detailed_error_.reset();
  }
  if (referencing_) {
    const bool has_time_passed = now - motion_.started > to_time(options_.blocked_time);
    motion_.seen_moving |= reading_.moving;
    if (!reading_.moving && reading_.referenced && (motion_.seen_moving || has_time_passed)) {
      referencing_ = false;
      note_(false, "the gripper is referenced");
    }
  }
  watch_stop(now);
  update_motion(now);
}

void Driver::take_refusal(const Refusal& refusal, Time now) {
  const std::string words =
      command_name(static_cast<std::uint8_t>(refusal.command)) +
      " was refused: " + describe_code(static_cast<std::uint8_t>(refusal.reason));
  if (refusal.command == Command::kGetConfig && !unit_known_) {
    note_(true, words + "; mm is assumed as its unit");
    take_unit(1e-3, now);
  }
  answered(refusal.command, now);
  if (refusal.command == Command::kStop) {
    if (reading_.moving) escalate(words, now);  // else there is nothing to stop
    return;
  }
  if (refusal.command == Command::kGetDetailedError || refusal.command == Command::kGetConfig) {
    return;
  }
  if (refusal.command == Command::kReference) referencing_ = false;
  note_(true, words);
  if (is_motion_command(refusal.command) && !motion_.ended) end_motion(words);
}

// A hint, which states have to bear out (conclude_end): a message may be delayed, or false.
void Driver::take_motion_end(const MotionEnd& end, Time now) {
  if (motion_.ended || !motion_.accepted || !std::isfinite(end.position)) return;
  const double opening = to_opening(end.position);
  const double rest = std::abs(opening - motion_.target);
  const bool has_begun = motion_.seen_moving || rest < options_.opening_tolerance;
  // One that was delayed may belong to the motion before.
  const bool is_elsewhere =
      end.kind == Command::kPositionReached && rest > options_.opening_tolerance;
  const bool is_stale =
      !has_begun || is_elsewhere ||
      std::abs(opening - reading_.opening) > 4 * options_.limits.max_speed * options_.state_period;
  if (!is_stale) motion_.end_told = now;
}

void Driver::take_fault(const Fault& fault_message, Time now) {
  const auto code = static_cast<std::uint8_t>(fault_message.code);
  if (fault_message.kind == Command::kError) return fault(code, now);
  if (reading_.warning_code != code) note_(true, "warning: " + describe_code(code));
  reading_.warning_code = code;
}

void Driver::fault(std::uint8_t code, Time now) {
  const bool is_new = !fault_told_ || reading_.error_code != code;
  reading_.error_code = code;
  reading_.moving = false;
  reading_.blocked = false;
  referencing_ = false;
  fault_told_ = true;
  if (!is_new) return;
  end_motion(describe_code(code));
  note_(true, describe_code(code) + "; call /gripper/acknowledge when its cause is gone");
  transmit(PlainRequest{Command::kGetDetailedError}, now);
}

void Driver::take_info(const Info& info, Time now) {
  switch (static_cast<InfoCode>(info.code)) {
    case InfoCode::kBoot:
      note_(true, "the module has restarted");
      return begin_connecting(now);
    case InfoCode::kNoError:
      reading_.error_code = 0;
      reading_.warning_code = 0;
      fault_told_ = false;
      return;
    default:
      note_(false, info.code <= 0xFF ? describe_code(static_cast<std::uint8_t>(info.code))
                                     : "unknown information " + std::to_string(info.code));
  }
}

void Driver::take_config(const ConfigValue& value, Time now) {
  answered(Command::kGetConfig, now);
  if (value.parameter != static_cast<std::uint8_t>(ConfigParameter::kUnitSystem) ||
      value.value.empty()) {
    return;
  }
  switch (static_cast<UnitSystem>(value.value[0])) {
    case UnitSystem::kMillimetre:
      return take_unit(1e-3, now);
    case UnitSystem::kMetre:
      return take_unit(1, now);
    case UnitSystem::kInch:
      return take_unit(0.0254, now);
    default:
      if (!obstacle_.empty()) return;
      obstacle_ = "the module's unit system " + std::to_string(value.value[0]) +
                  " is no length in floating point; set it to mm (0) or m (1) with Schunk's "
                  "configuration program";
      note_(true, obstacle_);
  }
}

// With the unit known, MOVE VEL and the like get the acceleration that the limits allow: the
// module's own default is a tenth of it.
void Driver::take_unit(double unit, Time now) {
  unit_ = unit;
  unit_known_ = true;
  transmit(SetTarget{Command::kSetTargetAcceleration, to_device(options_.limits.max_acceleration)},
           now);
}

}  // namespace prehend::drivers::pg70
