#include "drivers/dsa/driver/probe.h"

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <string_view>

#include "drivers/dsa/codec/packet.h"
#include "drivers/dsa/codec/structures.h"
#include "drivers/wire/stream/byte_stream.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::dsa {
namespace {

constexpr auto kListening = std::chrono::milliseconds(150);  // several frames
constexpr auto kRepeat = std::chrono::milliseconds(400);

/// Packets of a line, and what else comes on it.
class Ear {
 public:
  explicit Ear(ByteStream& stream) : stream_(stream) {}
  /// The first packet within `time` that is wanted.
  std::optional<Packet> listen(std::chrono::nanoseconds time,
                               const std::function<bool(const Packet&)>& is_wanted) {
    const Time end = steady_now() + time;
    std::array<std::uint8_t, 2048> buffer;
    while (true) {
      while (auto packet = decoder_.next()) {
        if (is_wanted(*packet)) return packet;
      }
      const Time now = steady_now();
      if (now >= end) return std::nullopt;
      const IoResult result = stream_.read(buffer, end - now);
      if (result.status == IoStatus::kClosed) {
        trouble = result.problem;
        return std::nullopt;
      }
      decoder_.add(Bytes(buffer).first(result.count));
      bytes += result.count;
      // At power-up the controller prints ESC [5n some times.
      constexpr std::string_view kGreeting = "\x1b[5n";
      const std::string_view text(reinterpret_cast<const char*>(buffer.data()), result.count);
      starts_up = starts_up || text.find(kGreeting) != std::string_view::npos;
    }
  }
  std::optional<Packet> ask(PacketId id, std::chrono::nanoseconds patience) {
    const auto code = static_cast<std::uint8_t>(id);
    const Time end = steady_now() + patience;
    for (Time now = steady_now(); now < end && trouble.empty(); now = steady_now()) {
      const IoResult result = stream_.write(encode_packet(code, {}), kRepeat);
      if (result.status != IoStatus::kOk) {
        trouble = result.problem;
        break;
      }
      auto answer = listen(std::min<std::chrono::nanoseconds>(kRepeat, end - now),
                           [&](const Packet& packet) { return packet.id == code; });
      if (answer) return answer;
    }
    return std::nullopt;
  }

  std::size_t bytes = 0;
  bool starts_up = false;
  std::string trouble;

 private:
  ByteStream& stream_;
  PacketDecoder decoder_;
};

Probe silent(const std::string& line, const Ear& ear) {
  Probe probe{Probe::Result::kSilent, "the tactile controller does not answer on " + line,
              "check its supply, that it is this line and not another, and wait 10 s after "
              "power-on"};
  if (!ear.trouble.empty()) {
    probe.what += ": " + ear.trouble;
  } else if (ear.starts_up) {
    probe.what += " yet: it is starting up";
    probe.mend = "ask again in 10 s";
  } else if (ear.bytes > 0) {
    probe.what += "; what comes is none of its packets";
    probe.mend = "another device or another bit rate: the controller's is 115200";
  }
  return probe;
}

}  // namespace

Probe probe(const std::string& line, unsigned baud, std::chrono::nanoseconds patience) {
  const auto stream = open_byte_stream(line, baud);
  Ear ear(*stream);
  const auto is_frame = [](const Packet& packet) {
    return packet.id == static_cast<std::uint8_t>(PacketId::kFrame);
  };
  const std::string who = "tactile controller on " + line;
  if (ear.listen(kListening, is_frame)) {
    return {Probe::Result::kAnswers, who + " streams frames", {}};
  }
  const auto answer = ear.ask(PacketId::kControllerInfo, patience);
  if (!answer) return silent(line, ear);
  const auto status = decode_status(answer->payload);
  const auto info = decode_controller_info(answer->payload);
  if (!info || *status != 0) {
    return {Probe::Result::kSilent,
            who + " answers " +
                (status && *status != 0 ? describe_status(*status)
                                        : std::string("with an unknown layout")),
            "switch it off and on"};
  }
  const std::string facts = ", serial number " + std::to_string(info->serial) + ", firmware " +
                            std::to_string(info->software);
  const auto sensor_answer = ear.ask(PacketId::kSensorInfo, patience);
  const auto sensor =
      sensor_answer ? decode_sensor_info(sensor_answer->payload) : std::optional<SensorInfo>();
  if (!sensor || sensor->status != 0 || sensor->matrices == 0) {
    return {Probe::Result::kWarns, who + " answers" + facts + ", but knows no pads",
            "plug the pads in, switch it off and on"};
  }
  return {Probe::Result::kAnswers,
          who + " answers: " + std::to_string(sensor->matrices) + " pads" + facts,
          {}};
}

}  // namespace prehend::drivers::dsa
