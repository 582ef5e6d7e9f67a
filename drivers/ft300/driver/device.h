#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/ft300/codec/measurement.h"
#include "drivers/ft300/transport/modbus_line.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::ft300 {

struct DeviceOptions {
  std::string line = "/dev/ttyUSB0";  // or tcp://HOST:PORT of a gateway
  unsigned baud = 19200;              // the sensor's only one, manual page 65
  std::uint8_t unit = 9;
  bool stream = true;       // 100 Hz; false: registers are polled. A gateway is always polled.
  double rate = 100;        // 1/s of polling, at most; a serial line gives some 40
  double reply_time = 0.2;  // s to wait for an answer
  double stale_time = 0.2;  // s without measurement that are reported; then it begins anew
  double retry = 0.5;       // s between tries to open the line
  double grace = 2;         // s at first in which a line that cannot be opened is not told
  // A stream is over when nothing came for `silence`; Modbus is served `rest` later [s]
  // (rq_sensor_com.cpp).
  double silence = 0.08;
  double rest = 0.1;
};

/// Where the measuring is. The sensor moves nothing, and measures whenever it has power.
///
/// | state         | measurements                                                               |
/// |---------------|----------------------------------------------------------------------------|
/// | kDisconnected | none: the line cannot be opened, or is gone; tried again                   |
/// | kIdentifying  | none: a stream left on is stopped, the firmware is asked for               |
/// | kMeasuring    | handed on                                                                  |
/// | kStale        | none for stale_time, or no good answers; reported; begun anew              |
enum class DeviceState { kDisconnected, kIdentifying, kMeasuring, kStale };
const char* to_string(DeviceState state);

struct Statistics {
  std::uint64_t measurements = 0;
  std::uint64_t failures = 0;   // transactions without a good answer
  std::uint64_t discarded = 0;  // bytes of the stream that belonged to no message
  std::uint64_t connections = 0;
  double rate = 0;  // 1/s, of the last second
};

/// The sensor on its line: a thread connects, identifies, measures, and connects again when it is
/// lost.
class Device {
 public:
  using OnMeasurement = std::function<void(const Measurement&)>;
  using Note = std::function<void(bool is_problem, const std::string& words)>;
  /// Both functions are called by the thread.
  /// @throws std::invalid_argument for options that are not positive and finite.
  Device(const DeviceOptions& options, OnMeasurement on_measurement, Note note);
  /// Ends a stream, so that the next client finds Modbus.
  ~Device();

  DeviceState state() const { return state_; }
  Statistics statistics() const;
  /// "FTS-2.0.1", "" before it is known.
  std::string firmware() const;
  /// What is wrong, as it was noted; "" once a measurement came, or before anything went wrong.
  std::string trouble() const;

 private:
  void run();
  void fail(const std::string& words, DeviceState state);
  void connect();
  void identify();
  void measure();
  void read_stream();
  void poll();
  void take(const Measurement& measurement);
  void end_stream();
  void wait(double seconds) const;

  DeviceOptions options_;
  OnMeasurement on_measurement_;
  Note note_;
  std::unique_ptr<ModbusLine> line_;
  StreamDecoder stream_;
  bool streams_ = false;
  Time begun_{};
  bool was_open_ = false;
  Time last_measurement_{};
  Time next_poll_{};
  Time window_begin_{};
  std::uint64_t window_count_ = 0;
  std::atomic<DeviceState> state_ = DeviceState::kDisconnected;
  mutable std::mutex mutex_;  // guards what follows
  Statistics statistics_;
  std::uint64_t discarded_before_ = 0;  // by earlier connections
  std::string firmware_;
  std::string trouble_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers::ft300
