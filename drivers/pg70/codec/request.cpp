#include "drivers/pg70/codec/request.h"

#include <stdexcept>
#include <string>

namespace prehend::drivers::pg70 {
namespace {

Content begin(Command command) {
  Content content;
  content.append_number(static_cast<std::uint8_t>(command));
  return content;
}

struct RequestEncoder {
  Content operator()(const PlainRequest& request) const { return begin(request.command); }
  Content operator()(const SetTarget& request) const {
    Content content = begin(request.command);
    content.append_number(request.value);
    return content;
  }
  Content operator()(const Move& request) const {
    if (request.count < 1 || request.count > most_values(request.command)) {
      throw std::invalid_argument(command_name(static_cast<std::uint8_t>(request.command)) +
                                  " does not take " + std::to_string(request.count) + " values");
    }
    Content content = begin(request.command);
    for (int i = 0; i < request.count; ++i) content.append_number(request.values[i]);
    return content;
  }
  Content operator()(const GetState& request) const {
    Content content = begin(Command::kGetState);
    if (request.cycle) {
      content.append_number(request.cycle->period);
      content.append_number(request.cycle->mode);
    }
    return content;
  }
  Content operator()(const GetConfig& request) const {
    Content content = begin(Command::kGetConfig);
    if (request.parameter) content.append_number(*request.parameter);
    return content;
  }
  Content operator()(const SetConfig& request) const {
    Content content = begin(Command::kSetConfig);
    content.append_number(request.parameter);
    content.append(request.value);
    return content;
  }
  Content operator()(const OtherRequest& request) const { return request.content; }
};

bool is_plain(Command command) {
  switch (command) {
    case Command::kAcknowledge:
    case Command::kStop:
    case Command::kFastStop:
    case Command::kReference:
    case Command::kReferenceHand:
    case Command::kGetDetailedError:
    case Command::kReboot:
    case Command::kToggleImpulse:
      return true;
    default:
      return false;
  }
}

bool is_set_target(Command command) {
  const auto code = static_cast<std::uint8_t>(command);
  return code >= 0xA0 && code <= 0xA7 && code != 0xA5;
}

std::optional<Request> decode_move(Command command, Bytes parameters) {
  const std::size_t count = parameters.size() / sizeof(float);
  if (count < 1 || count > static_cast<std::size_t>(most_values(command)) ||
      parameters.size() % sizeof(float) != 0) {
    return std::nullopt;
  }
  Move move{.command = command, .count = static_cast<std::uint8_t>(count)};
  for (std::size_t i = 0; i < count; ++i) {
    move.values[i] = load_little<float>(&parameters[i * sizeof(float)]);
  }
  return move;
}

std::optional<Request> decode_fitting(Command command, Bytes parameters) {
  ByteReader reader(parameters);
  if (is_plain(command) && parameters.empty()) return PlainRequest{command};
  if (is_set_target(command) && parameters.size() == sizeof(float)) {
    return SetTarget{command, reader.take<float>()};
  }
  if (most_values(command) > 0) return decode_move(command, parameters);
  if (command == Command::kGetState) {
    if (parameters.empty()) return GetState{};
    GetState::Cycle cycle;
    cycle.period = reader.take<float>();
    cycle.mode = reader.take<std::uint8_t>();
    if (reader.complete()) return GetState{cycle};
  }
  if (command == Command::kGetConfig) {
    if (parameters.empty()) return GetConfig{};
    if (parameters.size() == 1) return GetConfig{parameters[0]};
  }
  if (command == Command::kSetConfig && parameters.size() >= 2) {
    return SetConfig{parameters[0], {parameters.begin() + 1, parameters.end()}};
  }
  return std::nullopt;
}

}  // namespace

int most_values(Command command) {
  switch (command) {
    case Command::kMovePosition:
    case Command::kMovePositionRelative:
    case Command::kMovePositionTime:
    case Command::kMovePositionTimeRelative:
      return 5;
    case Command::kMoveVelocity:
      return 2;
    case Command::kMoveCurrent:
    case Command::kMoveGrip:
      return 1;
    default:
      return 0;
  }
}

Content encode(const Request& request) { return std::visit(RequestEncoder{}, request); }

Request decode_request(const Content& content) {
  const auto fitting =
      decode_fitting(static_cast<Command>(content.command()), content.parameters());
  return fitting ? *fitting : Request(OtherRequest{content});
}

}  // namespace prehend::drivers::pg70
