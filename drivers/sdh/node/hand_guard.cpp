// What stops a hand whose driver died, or does nothing.

#include "drivers/sdh/node/hand_guard.h"

#include <array>
#include <optional>
#include <string_view>
#include <variant>

#include "drivers/sdh/codec/stream.h"
#include "drivers/wire/guardian/insist.h"
#include "drivers/wire/stream/byte_stream.h"

namespace prehend::drivers::sdh {
namespace {

constexpr int kStops = 3;  // without an answer, then the axes are switched off with each
constexpr auto kReplyTime = std::chrono::milliseconds(100);

bool say(ByteStream& line, std::string_view text) {
  const Bytes bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  return line.write(bytes, kReplyTime).status == IoStatus::kOk;
}

// "stop", "power off": the one that was answered; empty when none was before `end`.
std::string stop_hand(ByteStream& line, Time end, const std::function<bool()>& is_back) {
  // Whatever form the driver spoke, what is asked here is answered by lines. Remains of a binary
  // message are taken for damage.
  ReplyDecoder decoder(!line.name().starts_with("tcp"));
  std::array<std::uint8_t, 512> buffer;
  const auto stops = [&](int tries) {
    // The line's end first: a half-typed command must not swallow it.
    return say(line, "\r\nstop\r\n") && (tries <= kStops || say(line, "power=0,0,0,0,0,0,0\r\n"));
  };
  return insist(end, is_back, kReplyTime, stops, [&](auto wait) -> std::optional<std::string> {
    const IoResult result = line.read(buffer, wait);
    if (result.status == IoStatus::kClosed) return std::nullopt;
    decoder.add(Bytes(buffer).first(result.count));
    while (const auto reply = decoder.next()) {
      const auto* words = std::get_if<LineReply>(&*reply);
      if (words == nullptr || words->error) continue;
      if (words->name == "STOP") return "stop";
      if (words->name == "POWER") return "power off";
    }
    return "";
  });
}

}  // namespace

GuardianProgram guardian_program(const std::string& line, unsigned baud) {
  return {"sdh_guardian", {line, std::to_string(baud)}, "hand"};
}

Guarding guarding(const std::string& line, unsigned baud) {
  return {"sdh_guardian", "hand", "stop",
          [line, baud](Time end, const std::function<bool()>& is_back) {
            return stop_hand(*open_byte_stream(line, baud), end, is_back);
          }};
}

}  // namespace prehend::drivers::sdh
