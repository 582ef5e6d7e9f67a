// What stops a hand whose driver died, or does nothing.

#include "drivers/barrett/node/hand_guard.h"

#include <algorithm>
#include <array>
#include <optional>
#include <variant>

#include "drivers/barrett/driver/device.h"
#include "drivers/wire/guardian/insist.h"

namespace prehend::drivers::barrett {
namespace {

constexpr int kStops = 3;  // without an answer, then CMD T goes with each
constexpr auto kReplyTime = std::chrono::milliseconds(50);

bool say(CanBus& bus, std::size_t axis, Property property,
         std::optional<std::int32_t> value = std::nullopt) {
  return bus.send(encode(Request{axis, static_cast<std::uint8_t>(property), value})).empty();
}

// "MODE 0" once each puck has shown it after it was told; empty when that was not before `end`.
std::string stop_hand(CanBus& bus, Time end, const std::function<bool()>& is_back) {
  std::array<bool, kAxes> stands{};
  const auto stops = [&](int tries) {
    for (std::size_t i = 0; i < kAxes; ++i) {
      if (stands[i]) continue;
      if (tries > kStops) say(bus, i, Property::kCommand, static_cast<int>(Command::kOff));
      if (!say(bus, i, Property::kMode, static_cast<int>(Mode::kIdle))) return false;
      if (!say(bus, i, Property::kMode)) return false;
    }
    return true;
  };
  return insist(end, is_back, kReplyTime, stops, [&](auto wait) -> std::optional<std::string> {
    const auto input = bus.receive(wait);
    if (!input) return "";
    if (const auto* event = std::get_if<CanEvent>(&*input)) {
      if (event->kind == CanEvent::Kind::kClosed) return std::nullopt;
      return "";
    }
    const auto reply = decode_reply(std::get<CanFrame>(*input));
    const auto* value = reply ? std::get_if<Value>(&*reply) : nullptr;
    if (value && value->property == static_cast<std::uint8_t>(Property::kMode) &&
        value->value == static_cast<int>(Mode::kIdle)) {
      stands[value->axis] = true;
    }
    return std::ranges::all_of(stands, [](bool on) { return on; }) ? "MODE 0" : "";
  });
}

}  // namespace

GuardianProgram guardian_program(const std::string& bus, unsigned bit_rate) {
  return {"barrett_guardian", {kByBus, bus, std::to_string(bit_rate), "0"}, "hand"};
}

Guarding guarding(const std::string& bus, unsigned bit_rate) {
  return {"barrett_guardian", "hand", "MODE 0",
          [bus, bit_rate](Time end, const std::function<bool()>& is_back) {
            return stop_hand(*open_hand_bus(bus, bit_rate), end, is_back);
          }};
}

}  // namespace prehend::drivers::barrett
