#include "drivers/sdh/driver/probe.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <string_view>

#include "drivers/sdh/codec/firmware.h"
#include "drivers/sdh/codec/stream.h"
#include "drivers/wire/stream/byte_stream.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::sdh {
namespace {

constexpr auto kListening = std::chrono::milliseconds(150);
constexpr auto kDrain = std::chrono::milliseconds(100);
constexpr int kTries = 2;

/// Lines of the hand, and what else comes.
class Ear {
 public:
  explicit Ear(ByteStream& stream) : stream_(stream) {}

  /// The reply of this name within `time`; none wanted: whatever comes is only counted.
  std::optional<LineReply> listen(std::chrono::nanoseconds time, std::string_view name) {
    const Time end = steady_now() + time;
    std::array<std::uint8_t, 1024> buffer;
    while (trouble.empty()) {
      while (const auto reply = decoder_.next()) {
        if (const auto* line = std::get_if<LineReply>(&*reply)) {
          if (line->error) code = line->error;
          if (line->name == name) return *line;
        }
      }
      const Time now = steady_now();
      if (now >= end) break;
      const IoResult result = stream_.read(buffer, end - now);
      if (result.status == IoStatus::kClosed) trouble = result.problem;
      bytes += result.count;
      decoder_.add(Bytes(buffer).first(result.count));
    }
    return std::nullopt;
  }
  std::optional<LineReply> ask(Command command, std::string_view name,
                               std::chrono::nanoseconds patience) {
    for (int i = 0; i < kTries && trouble.empty(); ++i) {
      say(encode(LineRequest{.name = to_string(command)}));
      if (auto reply = listen(patience, name)) return reply;
    }
    return std::nullopt;
  }
  void say(const std::string& text) {
    const IoResult result = stream_.write(
        {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, kListening);
    if (result.status != IoStatus::kOk) trouble = result.problem;
  }
  void forget() { decoder_.clear(); }

  std::size_t bytes = 0;
  std::optional<std::uint8_t> code;  // that it answered with
  std::string trouble;

 private:
  ByteStream& stream_;
  ReplyDecoder decoder_{true};
};

Probe silent(const std::string& line, const Ear& ear) {
  Probe probe{
      Probe::Result::kSilent, "the hand does not answer on " + line,
      "check its supply (24 V), that it is this line and not that of its pads; one that was "
      "on for long may be too hot to answer: switch it off and let it cool"};
  if (!ear.trouble.empty()) {
    probe.what += ": " + ear.trouble;
  } else if (ear.code) {
    probe.what += " as an SDH-2 does: it says " + describe_code(*ear.code);
  } else if (ear.bytes > 0) {
    probe.what += "; what comes is none of its lines";
    probe.mend = "another device (its pads?) or another bit rate: the hand's is 115200";
  }
  return probe;
}

}  // namespace

Probe probe(const std::string& line, unsigned baud, std::chrono::nanoseconds patience) {
  const auto stream = open_byte_stream(line, baud);
  Ear ear(*stream);
  ear.listen(kListening, "-");
  ear.say(" \r\n");  // ends a half-typed command
  ear.listen(kDrain, "-");
  ear.forget();
  const std::string who = "SDH-2 on " + line;
  const auto version = ear.ask(Command::kVersion, "VER", patience);
  if (!version) return silent(line, ear);
  const auto firmware = firmware_of(version->text.value_or(""));
  if (!firmware) {
    return {Probe::Result::kSilent,
            who + " says that its firmware is '" + version->text.value_or("") +
                "', which is none of an SDH-2",
            "check that this is the hand's line"};
  }
  Probe probe{Probe::Result::kAnswers, who + " answers: firmware " + firmware->text(), {}};
  const auto states = ear.ask(Command::kState, "STATE", patience);
  const std::vector<double> axes =
      states ? numbers_of(states->text.value_or("")) : std::vector<double>();
  if (axes.size() != kAxes) {
    probe.result = Probe::Result::kWarns;
    probe.what += ", but does not tell the states of its axes";
    probe.mend = "switch it off and on";
    return probe;
  }
  const auto count = [&](AxisState state) {
    return std::ranges::count(axes, static_cast<double>(state));
  };
  const auto off = count(AxisState::kDisabled);
  probe.what += off == static_cast<long>(kAxes) ? ", axes off"
                                                : ", " + std::to_string(kAxes - off) + " axes on";
  const auto temperatures = ear.ask(Command::kTemperature, "TEMP", patience);
  const std::vector<double> celsius =
      temperatures ? numbers_of(temperatures->text.value_or("")) : std::vector<double>();
  if (!celsius.empty()) {
    char words[48];
    std::snprintf(words, sizeof words, ", %.0f degree Celsius at most", std::ranges::max(celsius));
    probe.what += words;
  }
  if (count(AxisState::kNotInitialised) > 0) {
    probe.result = Probe::Result::kWarns;
    probe.what += "; an axis is not initialised";
    probe.mend = "switch its supply off and on";
  }
  return probe;
}

}  // namespace prehend::drivers::sdh
