#include "drivers/pg70/emulator/module.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace prehend::drivers::pg70 {
namespace {

using Drive = GripperPlant::Drive;

}  // namespace

Module::Module(GripperPlant& plant, const ModuleOptions& options, Send send)
    : plant_(plant),
      options_(options),
      send_(std::move(send)),
      // Factory targets: 10 % of the maximum (spatialaudio/schunk).
      speed_(0.1 * options.max_speed),
      acceleration_(0.1 * options.max_acceleration),
      current_(options.nominal_current),
      impulse_on_(options.impulse_messages),
      referenced_(options.referenced) {
  motion_ = plant_.advance(0);
}

double Module::unit() const {
  return options_.unit == UnitSystem::kMetre  ? 1.0
         : options_.unit == UnitSystem::kInch ? 0.0254
                                              : 1e-3;
}

void Module::say(const Response& response) {
  if (!mute_ && !boots_until_) send_(direction_of(response), encode(response));
}

void Module::impulse(const Response& response) {
  if (impulse_on_) say(response);
}

void Module::receive(const Content& content, Time now) {
  if (boots_until_ || content.size() == 0) return;
  if (deaf_to_ && content.command() == static_cast<std::uint8_t>(*deaf_to_)) return;
  std::visit([&](const auto& request) { take(request, now); }, decode_request(content));
}

void Module::halt(Drive drive) {
  plant_.command({.drive = drive, .acceleration = options_.max_acceleration, .current = current_});
  if (moving_) ended_ = true;
  moving_ = referencing_ = false;
}

void Module::take(const PlainRequest& request, Time now) {
  switch (request.command) {
    case Command::kAcknowledge:
      return acknowledge(now);
    case Command::kStop: {
      ++stops_;
      halt(error_ == ErrorCode::kNone ? Drive::kHold : Drive::kOff);
      return say(Confirmation{Command::kStop});
    }
    case Command::kFastStop:
      ++stops_;
      return fail(ErrorCode::kFastStop, false, now);  // its only answer
    case Command::kReference:
      if (error_ != ErrorCode::kNone && !warning_) {
        return refuse(request.command, InfoCode::kFailed);
      }
      say(Confirmation{Command::kReference});
      referenced_ = false;
      begin({.drive = Drive::kPosition,
             .value = 0,
             .speed = 0.5 * options_.max_speed,
             .acceleration = options_.max_acceleration,
             .current = options_.nominal_current},
            Command::kReference);
      referencing_ = true;
      return;
    case Command::kReferenceHand:
      referenced_ = true;
      return say(Confirmation{request.command});
    case Command::kGetDetailedError:
      if (error_ == ErrorCode::kNone) return refuse(request.command, InfoCode::kFailed);
      return say(DetailedError{warning_ ? Command::kWarning : Command::kError,
                               static_cast<std::uint8_t>(error_), to_device(motion_.opening)});
    case Command::kReboot:
      say(Confirmation{request.command});
      return reboot(now);
    case Command::kToggleImpulse:
      impulse_on_ = !impulse_on_;
      return say(ImpulseMessages{impulse_on_});
    default:
      return refuse(request.command, InfoCode::kUnknownCommand);
  }
}

void Module::take(const SetTarget& request, Time) {
  double* target = nullptr;
  double most = 0;
  double scale = unit();
  switch (request.command) {
    case Command::kSetTargetVelocity:
      target = &speed_;
      most = options_.max_speed;
      break;
    case Command::kSetTargetAcceleration:
      target = &acceleration_;
      most = options_.max_acceleration;
      break;
    case Command::kSetTargetCurrent:
      target = &current_;
      most = options_.max_current;
      scale = 1;
      break;
    default:  // jerk, time and positions are kept by the real module; nothing here depends on them
      if (!std::isfinite(request.value)) return refuse(request.command, InfoCode::kWrongParameter);
      return say(Confirmation{request.command});
  }
  const double value = request.value * scale;
  if (!(value > 0)) return refuse(request.command, InfoCode::kWrongParameter);
  if (value > most * 1.0001) return refuse(request.command, InfoCode::kValueAboveMaximum);
  *target = value;
  say(Confirmation{request.command});
}

std::optional<InfoCode> Module::reason_against(const Move& move) const {
  if (error_ != ErrorCode::kNone && !warning_) return InfoCode::kFailed;
  const bool is_current =
      move.command == Command::kMoveCurrent || move.command == Command::kMoveGrip;
  const bool is_velocity = move.command == Command::kMoveVelocity;
  for (int i = 0; i < move.count; ++i) {
    if (!std::isfinite(move.values[i])) return InfoCode::kWrongParameter;
    if (i > 0 && !(move.values[i] > 0)) return InfoCode::kWrongParameter;
  }
  const double value = move.values[0] * (is_current ? 1 : unit());
  if (is_current) {
    if (std::abs(value) > options_.max_current * 1.0001) return InfoCode::kValueAboveMaximum;
    return std::nullopt;
  }
  if (is_velocity) {
    if (std::abs(value) > options_.max_speed * 1.0001) return InfoCode::kValueAboveMaximum;
    if (move.count > 1 && move.values[1] > options_.max_current) {
      return InfoCode::kValueAboveMaximum;
    }
    return std::nullopt;
  }
  if (!referenced_) return InfoCode::kNotReferenced;
  const bool is_relative = move.command == Command::kMovePositionRelative ||
                           move.command == Command::kMovePositionTimeRelative;
  const double target = value + (is_relative ? motion_.opening : 0);
  constexpr double kRounding = 1e-7;  // m, of binary32
  if (target > options_.max_opening + kRounding) return InfoCode::kValueAboveMaximum;
  if (target < -kRounding) return InfoCode::kValueBelowMinimum;
  const double most[] = {options_.max_speed / unit(), options_.max_acceleration / unit(),
                         options_.max_current};
  for (int i = 1; i < std::min<int>(move.count, 4); ++i) {
    if (move.values[i] > most[i - 1] * 1.0001) return InfoCode::kValueAboveMaximum;
  }
  return std::nullopt;
}

void Module::take(const Move& request, Time /*now*/) {
  if (const auto reason = reason_against(request)) return refuse(request.command, *reason);
  drive(request);
}

void Module::drive(const Move& move) {
  GripperPlant::Command command{.acceleration = acceleration_, .current = current_};
  switch (move.command) {
    case Command::kMoveCurrent:
    case Command::kMoveGrip:
      command.drive = Drive::kCurrent;
      command.value = move.values[0];
      command.acceleration = options_.max_acceleration;
      say(Confirmation{move.command});
      return begin(command, move.command);
    case Command::kMoveVelocity:
      command.drive = Drive::kVelocity;
      command.value = move.values[0] * unit();
      if (move.count > 1) command.current = current_ = move.values[1];
      say(Confirmation{move.command});
      return begin(command, move.command);
    default:
      break;
  }
  const bool is_relative = move.command == Command::kMovePositionRelative ||
                           move.command == Command::kMovePositionTimeRelative;
  if (move.count > 1) speed_ = move.values[1] * unit();
  if (move.count > 2) acceleration_ = move.values[2] * unit();
  if (move.count > 3) current_ = move.values[3];
  command.drive = Drive::kPosition;
  command.value = move.values[0] * unit() + (is_relative ? motion_.opening : 0);
  command.speed = speed_;
  command.acceleration = acceleration_;
  command.current = current_;
  if (options_.tells_duration) {
    const double way = std::abs(command.value - motion_.opening);
    const double ramps = speed_ * speed_ / acceleration_;
    const double duration =
        way > ramps ? way / speed_ + speed_ / acceleration_ : 2 * std::sqrt(way / acceleration_);
    say(MoveStarted{move.command, static_cast<float>(duration)});
  } else {
    say(Confirmation{move.command});
  }
  begin(command, move.command);
}

void Module::begin(const GripperPlant::Command& command, Command by) {
  ++motions_;
  plant_.command(command);
  target_ = command.value;
  moved_by_ = by;
  moving_ = true;
  referencing_ = ended_ = reached_ = brake_ = false;
  standing_since_ = motion_.time;
}

void Module::take(const GetState& request, Time now) {
  if (!request.cycle) {
    period_ = {};
    return tell_state();
  }
  const float period = request.cycle->period;
  if (!(period >= 0 && period < 3600) || request.cycle->mode > kWithAll) {
    return refuse(Command::kGetState, InfoCode::kWrongParameter);
  }
  mode_ = request.cycle->mode;
  period_ = to_time(period);
  next_state_ = now + period_;
  tell_state();
}

void Module::take(const GetConfig& request, Time) {
  if (!request.parameter) {
    DeviceFacts facts;
    facts.type = {'P', 'G', '7', '0', 0, 0, 0, 0};
    facts.firmware = 141;
    facts.protocol = 2;
    return say(facts);
  }
  ConfigValue value{*request.parameter, {}};
  const auto number = [&](double v) { append_little(value.value, static_cast<float>(v)); };
  switch (static_cast<ConfigParameter>(*request.parameter)) {
    case ConfigParameter::kUnitSystem:
      value.value = {static_cast<std::uint8_t>(options_.unit)};
      break;
    case ConfigParameter::kSoftHigh:
      number(to_device(options_.max_opening));
      break;
    case ConfigParameter::kSoftLow:
      number(0);
      break;
    case ConfigParameter::kMaximumVelocity:
      number(to_device(options_.max_speed));
      break;
    case ConfigParameter::kMaximumAcceleration:
      number(to_device(options_.max_acceleration));
      break;
    case ConfigParameter::kMaximumCurrent:
      number(options_.max_current);
      break;
    case ConfigParameter::kNominalCurrent:
      number(options_.nominal_current);
      break;
    default:
      return refuse(Command::kGetConfig, InfoCode::kWrongParameter);
  }
  say(value);
}

void Module::take(const SetConfig&, Time) { refuse(Command::kSetConfig, InfoCode::kNoRights); }

void Module::take(const OtherRequest& request, Time) {
  const auto command = static_cast<Command>(request.content.command());
  const auto texts = command_texts();
  const bool is_known = std::ranges::any_of(
      texts, [&](const CodeText& text) { return text.code == request.content.command(); });
  refuse(command, is_known ? InfoCode::kMessageLength : InfoCode::kUnknownCommand);
}

}  // namespace prehend::drivers::pg70
