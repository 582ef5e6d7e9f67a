#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/ft300/codec/measurement.h"
#include "drivers/ft300/codec/modbus_rtu.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::ft300 {

struct SensorOptions {
  bool is_tcp = false;  // speaks Modbus TCP (the real sensor does not: as a gateway would)
  std::uint8_t unit = 9;
  double stream_rate = 100;   // 1/s
  std::string model = "FTS";  // three letters
};

/// An FT 300 over a measurement that somebody sets. Like the codecs it does no input or output:
/// bytes go to `send`. While it streams it serves no Modbus, and 50 bytes FF end that. Call
/// update() every few milliseconds.
class Sensor {
 public:
  using Send = std::function<void(Bytes)>;
  Sensor(const SensorOptions& options, Send send);

  void receive(Bytes bytes, Time now);
  void update(Time now);

  void set_measurement(const Measurement& measurement) { measurement_ = measurement; }
  void set_silent(bool silent) { silent_ = silent; }
  /// Power off and on: silent for half a second. A sensor that streamed goes on streaming.
  void reboot(Time now);
  bool is_streaming() const { return streams_; }
  std::uint64_t messages() const { return messages_; }  // of the stream

 private:
  ModbusReply reply_to(const ModbusRequest& request);
  std::optional<std::uint16_t> register_at(std::uint16_t address) const;
  void serve_tcp(Bytes bytes);
  void serve_rtu(Bytes bytes, Time now);
  void say(Bytes bytes) {
    if (!silent_) send_(bytes);
  }

  SensorOptions options_;
  Send send_;
  Measurement measurement_;
  RtuRequestDecoder requests_;
  std::vector<std::uint8_t> tcp_;
  bool streams_ = false;
  bool silent_ = false;
  int stop_bytes_ = 0;
  Time next_message_{};
  Time last_byte_{};
  Time boots_until_{};
  std::uint64_t messages_ = 0;
};

}  // namespace prehend::drivers::ft300
