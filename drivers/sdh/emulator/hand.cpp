#include "drivers/sdh/emulator/hand.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace prehend::drivers::sdh {
namespace {

// Of the binary form; the firmware has no others (SDHLibrary-CPP uses no others).
constexpr Command kBinaryCommands[] = {
    Command::kSpeed,        Command::kActualSpeed,  Command::kActualPosition, Command::kState,
    Command::kTarget,       Command::kAcceleration, Command::kTargetActual,   Command::kSpeedActual,
    Command::kCurrentLimit, Command::kPower};
constexpr std::uint8_t kNotSupported = 4;

std::string upper_case(std::string name) {
  for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

std::string two_decimals(double value) {
  char text[48];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

bool is_setting(Command command) {
  switch (command) {
    case Command::kActualSpeed:
    case Command::kActualPosition:
    case Command::kState:
    case Command::kSpeedLimit:
    case Command::kAccelerationLimit:
    case Command::kTemperature:
    case Command::kVersion:
    case Command::kDuration:
    case Command::kStop:
      return false;
    default:
      return true;
  }
}

}  // namespace

Hand::Hand(const HandOptions& options, Send send)
    : options_(options), send_(std::move(send)), decoder_(options.has_checksum) {
  if (options.plant == nullptr) throw std::invalid_argument("an emulated hand needs a plant");
  constexpr double kRoom = 25;  // degree Celsius
  temperatures_.fill(kRoom);
  power_on_defaults();
}

void Hand::power_on_defaults() {
  constexpr double kSpeed = 40, kAcceleration = 100;  // degree/s, degree/s^2
  target_.fill(0);
  speed_.fill(kSpeed);
  acceleration_.fill(kAcceleration);
  current_ = options_.current_limit;
  // The vendor's debug text shows these; not confirmed.
  grip_current_ = {1.0, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5};
  hold_current_ = {0.1, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2};
  powered_.fill(false);
  moving_.fill(false);
  blocked_.fill(false);
  at_limit_.fill(false);
  profile_ = controller_ = 0;
  grip_ = {};
}

void Hand::reboot(Time now) {
  boots_until_ = now + to_time(options_.boot_time);
  power_on_defaults();
  decoder_.clear();
  outputs_.clear();
  command_plant();
}

void Hand::put(Bytes bytes, Time now) {
  constexpr double kBits = 10;  // of a byte on the line
  const auto takes = options_.baud > 0
                         ? to_time(static_cast<double>(bytes.size()) * kBits / options_.baud)
                         : Time{};
  line_free_ = std::max(line_free_, now) + takes;
  outputs_.push_back({line_free_, {bytes.begin(), bytes.end()}});
}

void Hand::put(const std::string& line, Time now) {
  put(Bytes(reinterpret_cast<const std::uint8_t*>(line.data()), line.size()), now);
}

void Hand::debug(const std::string& words, Time now) {
  if (options_.debug_lines || !options_.firmware.is_terse()) put("@" + words + "\r\n", now);
}

void Hand::receive(Bytes bytes, Time now) {
  if (boots_until_) return;
  decoder_.add(bytes);
  while (const auto request = decoder_.next()) {
    if (const auto* code = std::get_if<ReturnCode>(&*request)) {
      // A damaged binary message is answered by nothing that the library would know of.
      if (*code == ReturnCode::kChecksum) continue;
      put(encode(LineReply{.error = static_cast<std::uint8_t>(*code)}), now);
    } else if (const auto* line = std::get_if<LineRequest>(&*request)) {
      take(*line, now);
    } else {
      take(std::get<BinaryRequest>(*request), now);
    }
  }
}

void Hand::take(const LineRequest& request, Time now) {
  const auto command = command_named(request.name);
  if (command && deaf_to_ == command) return;
  Outcome outcome{.error = static_cast<std::uint8_t>(ReturnCode::kUnknownCommand)};
  if (command) outcome = carry_out(*command, request.axis, request.values, now);
  if (outcome.error != 0) return put(encode(LineReply{.error = outcome.error}), now);
  LineReply reply{.name = upper_case(request.name), .axis = request.axis};
  if (outcome.text) {
    reply.text = *outcome.text;
  } else if (!outcome.is_bare) {
    const bool is_whole = command == Command::kState || command == Command::kPower;
    std::string text;
    for (std::size_t i = 0; i < kAxes; ++i) {
      if (request.axis && static_cast<int>(i) != *request.axis) continue;
      if (!text.empty()) text += ",";
      text += is_whole ? std::to_string(std::lround(outcome.values[i]))
                       : two_decimals(outcome.values[i]);
    }
    reply.text = text;
  }
  put(encode(reply), now);
}

void Hand::take(const BinaryRequest& request, Time now) {
  const auto command = static_cast<Command>(request.command);
  if (deaf_to_ == command) return;
  BinaryReply reply{.command = request.command};
  const bool is_known = options_.firmware.has_binary() &&
                        std::ranges::find(kBinaryCommands, command) != std::end(kBinaryCommands);
  if (is_known) {
    std::vector<double> values;
    if (request.values) values.assign(request.values->begin(), request.values->end());
    const Outcome outcome = carry_out(command, std::nullopt, values, now);
    reply.status = outcome.error;
    reply.values = outcome.values;
  } else {
    reply.status = kNotSupported;
  }
  put(encode(reply, options_.has_checksum), now);
}

Hand::Outcome Hand::carry_out(Command command, const std::optional<int>& axis,
                              const std::vector<double>& values, Time now) {
  if (refusal_ != 0 && (command == Command::kMove || (is_setting(command) && !values.empty()))) {
    return {.error = refusal_};
  }
  if (axis && *axis >= static_cast<int>(kAxes)) {
    return {.error = static_cast<std::uint8_t>(ReturnCode::kIndex)};
  }
  switch (command) {
    case Command::kMove:
    case Command::kStop:
    case Command::kProfile:
    case Command::kController:
    case Command::kTemperature:
    case Command::kVersion:
    case Command::kDuration:
    case Command::kSelectGrip:
    case Command::kGrip:
      if (axis) return {.error = static_cast<std::uint8_t>(ReturnCode::kCommandFormat)};
      return carry_out_of_hand(command, values, now);
    default:
      return carry_out_of_axes(command, axis, values);
  }
}

void Hand::stop() {
  ++stops_;
  if (grip_.runs) return;  // "grip" cannot be stopped (SDHLibrary-CPP, sdh.h)
  for (std::size_t i = 0; i < kAxes; ++i) {
    sent_[i] = reference_[i] = motion_.position[i] / kDegree;
    velocity_[i] = 0;
  }
  if (controller_ != 0) speed_.fill(0);
  moving_.fill(false);
  blocked_.fill(false);
  profile_time_ = 0;
}

bool Hand::is_moving() const {
  return std::ranges::any_of(moving_, [](bool on) { return on; });
}

bool Hand::is_hot() const { return std::ranges::max(temperatures_) > options_.hot; }

AxisState Hand::state(std::size_t axis) const {
  if (!powered_[axis]) return AxisState::kDisabled;
  if (blocked_[axis]) {
    // Which sense is clockwise is not published.
    return reference_[axis] > motion_.position[axis] / kDegree
               ? AxisState::kBlockedClockwise
               : AxisState::kBlockedCounterClockwise;
  }
  if (at_limit_[axis]) return AxisState::kLimitReached;
  if (controller_ != 0) return velocity_[axis] != 0 ? AxisState::kSpeed : AxisState::kIdle;
  return moving_[axis] ? AxisState::kPositioning : AxisState::kIdle;
}

}  // namespace prehend::drivers::sdh
