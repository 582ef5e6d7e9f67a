// What stops a BH8-262 whose driver died, or does nothing.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "drivers/barrett/codec/gcl/line.h"
#include "drivers/barrett/node/hand_guard.h"
#include "drivers/wire/guardian/insist.h"
#include "drivers/wire/stream/byte_stream.h"

namespace prehend::drivers::barrett::gcl {
namespace {

constexpr int kStops = 3;            // without an answer, then T goes with each
constexpr std::size_t kAborts = 13;  // of a block: a header, and three bytes a motor
constexpr auto kReplyTime = std::chrono::milliseconds(100);

bool say(ByteStream& line, std::string_view text) {
  const Bytes bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  return line.write(bytes, kReplyTime).status == IoStatus::kOk;
}

// "Ctrl-C" once a prompt has come; empty when none did before `end`.
std::string stop_hand(ByteStream& line, const std::array<unsigned, 2>& rates, Time end,
                      const std::function<bool()>& is_back) {
  std::string received;
  std::array<std::uint8_t, 512> buffer;
  const auto stops = [&](int tries) {
    received.clear();
    if (!line.set_baud(rates[static_cast<std::size_t>(tries - 1) % rates.size()]).empty()) {
      return false;
    }
    // The first one is alone: a hand that is in the middle of a line must not take another.
    return say(line, std::string(kAborts, kAbort) + (tries > 1 ? "\r" : "")) &&
           (tries <= kStops || say(line, "T\r"));
  };
  return insist(end, is_back, kReplyTime, stops, [&](auto wait) -> std::optional<std::string> {
    const IoResult result = line.read(buffer, wait);
    if (result.status == IoStatus::kClosed) return std::nullopt;
    received.append(reinterpret_cast<const char*>(buffer.data()), result.count);
    return ends_in_prompt(received) ? "Ctrl-C" : "";
  });
}

}  // namespace

GuardianProgram guardian_program(const std::string& line, unsigned baud, unsigned fast_baud) {
  return {
      "barrett_guardian", {kByLine, line, std::to_string(baud), std::to_string(fast_baud)}, "hand"};
}

Guarding guarding(const std::string& line, unsigned baud, unsigned fast_baud) {
  const std::array<unsigned, 2> rates{fast_baud > 0 ? fast_baud : baud, baud};
  return {"barrett_guardian", "hand", "Ctrl-C",
          [line, rates](Time end, const std::function<bool()>& is_back) {
            return stop_hand(*open_byte_stream(line, rates.front()), rates, end, is_back);
          }};
}

}  // namespace prehend::drivers::barrett::gcl
