// What stops a gripper whose driver died, or does nothing.

#include "drivers/pg70/node/gripper_guard.h"

#include <memory>
#include <string>
#include <variant>

#include "drivers/pg70/codec/request.h"
#include "drivers/pg70/codec/response.h"

namespace prehend::drivers::pg70 {
namespace {

constexpr int kStops = 3;  // without an answer, then CMD FAST STOP goes with each

// "CMD STOP", "CMD FAST STOP": the one that was answered; empty when none was before `end`.
std::string stop_module(Link& link, Time end, const std::function<bool()>& is_back) {
  const Content stop = encode(PlainRequest{Command::kStop});
  const Content fast_stop = encode(PlainRequest{Command::kFastStop});
  constexpr auto kReplyTime = std::chrono::milliseconds(50);
  for (int tries = 1; steady_now() < end; ++tries) {
    if (is_back()) return {};
    if (!link.send(Direction::kCommand, stop).empty()) return {};
    if (tries > kStops && !link.send(Direction::kCommand, fast_stop).empty()) return {};
    const Time again = steady_now() + kReplyTime;
    while (steady_now() < again) {
      const auto input = link.receive(again - steady_now());
      if (!input) break;
      if (const auto* event = std::get_if<LinkEvent>(&*input)) {
        if (event->kind == LinkEvent::Kind::kClosed) return {};
        continue;
      }
      const Content& content = std::get<Incoming>(*input).content;
      if (content.command() == stop.command()) return "CMD STOP";
      const Response response = decode_response(content, kWithAll);
      const auto* fault = std::get_if<Fault>(&response);
      if (fault && fault->code == ErrorCode::kFastStop) return "CMD FAST STOP";
    }
  }
  return {};
}

}  // namespace

GuardianProgram guardian_program(const LinkAddress& address) {
  return {"pg70_guardian",
          {address.line, std::to_string(address.bit_rate), std::to_string(address.module)},
          "gripper"};
}

Watch watch_of(const Reading& reading) {
  switch (reading.state) {
    case DriverState::kDisconnected:
      return Watch::kOff;
    case DriverState::kFault:
    case DriverState::kUnreferenced:
    case DriverState::kStanding:
    case DriverState::kHolding:
      return reading.moving ? Watch::kMoving : Watch::kStanding;
    default:
      return Watch::kMoving;
  }
}

Guarding guarding(const LinkAddress& address) {
  return {"pg70_guardian", "gripper", "CMD STOP",
          [address](Time end, const std::function<bool()>& is_back) {
            return stop_module(*open_link(address), end, is_back);
          }};
}

}  // namespace prehend::drivers::pg70
