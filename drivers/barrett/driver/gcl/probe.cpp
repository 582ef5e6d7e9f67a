#include "drivers/barrett/driver/gcl/probe.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "drivers/barrett/codec/gcl/line.h"
#include "drivers/wire/stream/byte_stream.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::barrett::gcl {
namespace {

constexpr auto kListening = std::chrono::milliseconds(150);
// 9600 as delivered, 38400 as handif had it, then what is slower to try.
constexpr std::array<unsigned, 7> kRates{9600, 38400, 19200, 4800, 2400, 1200, 600};

/// A line that is asked.
class Ear {
 public:
  explicit Ear(ByteStream& stream) : stream_(stream) {}

  /// Sends it with its CR; the answer, unless none comes within `patience`.
  std::optional<Reply> ask(const std::string& line, std::chrono::nanoseconds patience) {
    std::string received;
    const std::string text = line + "\r";
    const IoResult sent = stream_.write(
        {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, kListening);
    if (sent.status != IoStatus::kOk) trouble = sent.problem;
    const Time end = steady_now() + patience;
    while (trouble.empty() && steady_now() < end) {
      received += listen(end - steady_now());
      const Reply reply = parse_reply(received, line);
      if (reply.kind == Reply::Kind::kDone) return reply;
    }
    return std::nullopt;
  }
  /// What comes next.
  std::string listen(std::chrono::nanoseconds time) {
    std::array<std::uint8_t, 512> buffer;
    const IoResult result = stream_.read(buffer, time);
    if (result.status == IoStatus::kClosed) trouble = result.problem;
    bytes += result.count;
    return {reinterpret_cast<const char*>(buffer.data()), result.count};
  }

  std::size_t bytes = 0;  // that came
  std::string trouble;

 private:
  ByteStream& stream_;
};

}  // namespace

Probe probe(const std::string& line, std::chrono::nanoseconds patience) {
  const auto stream = open_byte_stream(line, kBaud);
  Ear ear(*stream);
  // A banner ends, a conversation does not.
  constexpr int kMostHeard = 100;  // reads
  int heard = 0;
  while (heard < kMostHeard && !ear.listen(kListening).empty()) ++heard;
  if (heard == kMostHeard) {
    return {Probe::Result::kWarns,
            "somebody talks with the BarrettHand on " + line + ", so it was not asked",
            "see what this page says of node barrett, or stop what uses the hand"};
  }
  std::optional<Reply> version;
  unsigned rate = 0;
  for (const unsigned baud : kRates) {
    ear.trouble = stream->set_baud(baud);
    // An empty line ends a half-typed one, and makes it prompt.
    ear.ask("", patience / 2);
    version = ear.ask("VERS", patience / 2);
    rate = baud;
    if (version || line.starts_with("tcp://")) break;
  }
  if (!version) {
    Probe silent{Probe::Result::kSilent, "the hand does not answer on " + line,
                 "check its supply (24 V) and that it is this line"};
    if (!ear.trouble.empty()) {
      silent.what += ": " + ear.trouble;
    } else if (ear.bytes > 0) {
      silent.what += " as a BarrettHand BH8-262 does; something else comes";
    }
    return silent;
  }
  std::string text;
  for (const std::string& words : version->lines) text += " " + words;
  Probe found{Probe::Result::kAnswers, "BarrettHand BH8-262 on " + line + " answers", {}};
  if (!line.starts_with("tcp://")) found.what += " at " + std::to_string(rate) + " baud";
  found.what += ":" + text;
  const auto values = [&](const char* question) {
    const auto reply = ear.ask(question, patience);
    return reply && reply->lines.size() == 1 ? integers_of(reply->lines.front())
                                             : std::vector<int>();
  };
  if (const std::vector<int> heat = values("PGET TEMP"); heat.size() == 1) {
    char words[48];
    std::snprintf(words, sizeof words, ", %.0f degree Celsius", 0.1 * heat[0]);
    found.what += words;
  }
  const std::vector<int> status = values("FGET S");
  int all = 0;
  for (const int one : status) all |= one;
  if (status.size() != kAxes || (all & (kNoBoard | kNoMotor)) != 0) {
    found.result = Probe::Result::kWarns;
    found.what += status.size() == kAxes ? "; it says " + describe_status(all)
                                         : "; it does not tell the status of its motors";
    found.mend = "switch its supply off and on";
  } else if ((all & kNotInitialised) != 0) {
    found.what += "; not initialised, as after power-on";
  }
  return found;
}

}  // namespace prehend::drivers::barrett::gcl
