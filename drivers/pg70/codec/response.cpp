#include "drivers/pg70/codec/response.h"

#include <bit>
#include <string_view>

#include "drivers/pg70/codec/request.h"

namespace prehend::drivers::pg70 {
namespace {

constexpr std::uint8_t kOk[2] = {0x4F, 0x4B};

std::uint8_t code_of(Command command) { return static_cast<std::uint8_t>(command); }

template <class... Numbers>
Content content_of(Command command, Numbers... numbers) {
  Content content;
  content.append_number(code_of(command));
  (content.append_number(numbers), ...);
  return content;
}

Content with_bytes(Content content, Bytes bytes) {
  content.append(bytes);
  return content;
}

template <class Container>
Bytes bytes_of(const Container& container) {
  return {reinterpret_cast<const std::uint8_t*>(container.data()), container.size()};
}

struct ResponseEncoder {
  Content operator()(const Refusal& r) const {
    return content_of(r.command, static_cast<std::uint8_t>(r.reason));
  }
  Content operator()(const Confirmation& r) const {
    return with_bytes(content_of(r.command), Bytes(kOk));
  }
  Content operator()(const MoveStarted& r) const { return content_of(r.command, r.duration); }
  Content operator()(const State& r) const {
    Content content = content_of(Command::kGetState);
    for (const auto& value : {r.position, r.velocity, r.current}) {
      if (value) content.append_number(*value);
    }
    content.append_number(r.status);
    content.append_number(r.error);
    return content;
  }
  Content operator()(const DetailedError& r) const {
    return content_of(Command::kGetDetailedError, code_of(r.kind), r.code, r.data);
  }
  Content operator()(const MotionEnd& r) const { return content_of(r.kind, r.position); }
  Content operator()(const Info& r) const { return content_of(Command::kInfo, r.code); }
  Content operator()(const Fault& r) const {
    return content_of(r.kind, static_cast<std::uint8_t>(r.code));
  }
  Content operator()(const ConfigValue& r) const {
    return with_bytes(content_of(Command::kGetConfig, r.parameter), r.value);
  }
  Content operator()(const ConfigSet& r) const {
    Content content = with_bytes(content_of(Command::kSetConfig), Bytes(kOk));
    content.append_number(r.parameter);
    return content;
  }
  Content operator()(const DeviceFacts& r) const {
    Content content = with_bytes(content_of(Command::kGetConfig), bytes_of(r.type));
    content.append_number(r.order_number);
    content.append_number(r.firmware);
    content.append_number(r.protocol);
    content.append_number(r.hardware);
    return with_bytes(with_bytes(content, bytes_of(r.date)), r.undocumented);
  }
  Content operator()(const ImpulseMessages& r) const {
    const std::string_view word = r.on ? "ON" : "OFF";
    return with_bytes(content_of(Command::kToggleImpulse), bytes_of(word));
  }
  Content operator()(const UserChanged& r) const {
    Content content = with_bytes(content_of(Command::kChangeUser), Bytes(kOk));
    content.append_number(r.user);
    return content;
  }
  Content operator()(const OtherResponse& r) const { return r.content; }
};

bool is_text(Bytes parameters, std::string_view text) {
  return std::ranges::equal(parameters, bytes_of(text));
}

std::optional<Response> decode_state(Bytes parameters, std::uint8_t mode) {
  if (parameters.size() < 2 || (parameters.size() - 2) % sizeof(float) != 0) return std::nullopt;
  const std::size_t floats = (parameters.size() - 2) / sizeof(float);
  if (floats > 3) return std::nullopt;
  mode &= kWithAll;
  if (static_cast<std::size_t>(std::popcount(mode)) != floats) {
    mode = static_cast<std::uint8_t>((1u << floats) - 1);
  }
  ByteReader reader(parameters);
  State state;
  if (mode & kWithPosition) state.position = reader.take<float>();
  if (mode & kWithVelocity) state.velocity = reader.take<float>();
  if (mode & kWithCurrent) state.current = reader.take<float>();
  state.status = reader.take<std::uint8_t>();
  state.error = reader.take<std::uint8_t>();
  return state;
}

std::optional<Response> decode_facts(Bytes parameters) {
  ByteReader reader(parameters);
  DeviceFacts facts;
  reader.take(reinterpret_cast<std::uint8_t*>(facts.type.data()), facts.type.size());
  facts.order_number = reader.take<std::uint32_t>();
  facts.firmware = reader.take<std::uint16_t>();
  facts.protocol = reader.take<std::uint16_t>();
  facts.hardware = reader.take<std::uint16_t>();
  reader.take(reinterpret_cast<std::uint8_t*>(facts.date.data()), facts.date.size());
  reader.take(facts.undocumented.data(), facts.undocumented.size());
  if (!reader.complete()) return std::nullopt;
  return facts;
}

bool has_duration(Command command) {
  return command == Command::kMovePosition || command == Command::kMovePositionRelative ||
         command == Command::kMovePositionTime || command == Command::kMovePositionTimeRelative;
}

// D-Len 2: nothing but faults and refusals has it.
Response decode_short(Command command, std::uint8_t code) {
  if (command == Command::kError || command == Command::kWarning) {
    return Fault{command, static_cast<ErrorCode>(code)};
  }
  return Refusal{command, static_cast<InfoCode>(code)};
}

std::optional<Response> decode_fitting(Command command, Bytes parameters, std::uint8_t mode) {
  ByteReader reader(parameters);
  if (parameters.size() == 1) return decode_short(command, parameters[0]);
  switch (command) {
    case Command::kError:
    case Command::kWarning:
      return std::nullopt;
    case Command::kGetState:
      return decode_state(parameters, mode);
    case Command::kInfo:
      if (parameters.size() == 2) return Info{reader.take<std::uint16_t>()};
      return std::nullopt;
    case Command::kMoveBlocked:
    case Command::kPositionReached:
      if (parameters.size() == sizeof(float)) return MotionEnd{command, reader.take<float>()};
      return std::nullopt;
    case Command::kGetDetailedError:
      if (parameters.size() == 6) {
        DetailedError error;
        error.kind = static_cast<Command>(reader.take<std::uint8_t>());
        error.code = reader.take<std::uint8_t>();
        error.data = reader.take<float>();
        return error;
      }
      return std::nullopt;
    case Command::kGetConfig:
      if (const auto facts = decode_facts(parameters)) return facts;
      if (parameters.size() < 2) return std::nullopt;
      return ConfigValue{parameters[0], {parameters.begin() + 1, parameters.end()}};
    case Command::kToggleImpulse:
      if (is_text(parameters, "ON")) return ImpulseMessages{true};
      if (is_text(parameters, "OFF")) return ImpulseMessages{false};
      break;
    case Command::kSetConfig:
    case Command::kChangeUser:
      if (parameters.size() == 3 && is_text(parameters.first(2), "OK")) {
        if (command == Command::kSetConfig) return ConfigSet{parameters[2]};
        return UserChanged{parameters[2]};
      }
      break;
    default:
      break;
  }
  if (is_text(parameters, "OK")) return Confirmation{command};
  if (has_duration(command) && parameters.size() == sizeof(float)) {
    return MoveStarted{command, reader.take<float>()};
  }
  return std::nullopt;
}

}  // namespace

Content encode(const Response& response) { return std::visit(ResponseEncoder{}, response); }

Response decode_response(const Content& content, std::uint8_t state_mode) {
  const auto fitting =
      decode_fitting(static_cast<Command>(content.command()), content.parameters(), state_mode);
  return fitting ? *fitting : Response(OtherResponse{content});
}

Direction direction_of(const Response& response) {
  return std::holds_alternative<Fault>(response) ? Direction::kError : Direction::kResponse;
}

}  // namespace prehend::drivers::pg70
