#include "drivers/ft300/driver/device.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>
#include <vector>

namespace prehend::drivers::ft300 {
namespace {

constexpr auto kTick = std::chrono::milliseconds(20);

void check_positive(double value, const char* name) {
  if (!(std::isfinite(value) && value > 0)) {
    throw std::invalid_argument(std::string("FT300: ") + name + " must be positive and finite");
  }
}

}  // namespace

const char* to_string(DeviceState state) {
  switch (state) {
    case DeviceState::kDisconnected:
      return "disconnected";
    case DeviceState::kIdentifying:
      return "identifying";
    case DeviceState::kMeasuring:
      return "measuring";
    case DeviceState::kStale:
      return "stale";
  }
  return "?";
}

Device::Device(const DeviceOptions& options, OnMeasurement on_measurement, Note note)
    : options_(options), on_measurement_(std::move(on_measurement)), note_(std::move(note)) {
  check_positive(options.rate, "rate");
  check_positive(options.reply_time, "reply_time");
  check_positive(options.stale_time, "stale_time");
  check_positive(options.retry, "retry");
  check_positive(options.silence, "silence");
  check_positive(options.rest, "rest");
  check_positive(options.grace, "grace");
  thread_ = std::thread([this] { run(); });
}

Device::~Device() {
  ends_ = true;
  thread_.join();
}

Statistics Device::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

std::string Device::firmware() const {
  const std::lock_guard lock(mutex_);
  return firmware_;
}

void Device::wait(double seconds) const {
  const Time end = steady_now() + to_time(seconds);
  while (!ends_ && steady_now() < end) std::this_thread::sleep_for(kTick);
}

std::string Device::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

void Device::fail(const std::string& words, DeviceState state) {
  // What is at the other end may be starting, too.
  const bool is_early = !was_open_ && steady_now() - begun_ < to_time(options_.grace);
  bool is_news = false;
  {
    const std::lock_guard lock(mutex_);
    is_news = !is_early && trouble_ != words;
    if (is_news) trouble_ = words;
    ++statistics_.failures;
    statistics_.rate = 0;
  }
  if (is_news) note_(true, words);
  state_ = state;
  line_.reset();
  streams_ = false;
  wait(options_.retry);
}

void Device::run() {
  begun_ = steady_now();
  while (!ends_) {
    try {
      connect();
      identify();
      while (!ends_) measure();
    } catch (const ModbusError& error) {
      fail(error.what(), error.closed ? DeviceState::kDisconnected : DeviceState::kStale);
    } catch (const std::runtime_error& error) {  // the line cannot be opened
      fail(error.what(), DeviceState::kDisconnected);
    }
  }
  if (!line_ || !streams_) return;
  try {
    end_stream();
  } catch (const ModbusError& error) {
    note_(true, std::string(error.what()) + "; the sensor may go on streaming");
  }
}

void Device::connect() {
  line_ = std::make_unique<ModbusLine>(
      options_.line, options_.baud, options_.unit,
      std::chrono::microseconds(static_cast<std::int64_t>(options_.reply_time * 1e6)));
  was_open_ = true;
}

// 50 bytes FF end a stream.
void Device::end_stream() {
  const std::vector<std::uint8_t> stop(50, 0xFF);
  constexpr auto kPatience = std::chrono::seconds(2);
  line_->write_bytes(stop);
  const Time end = steady_now() + kPatience;
  while (!line_->read_bytes(to_time(options_.silence)).empty() && steady_now() < end) {
  }
  std::this_thread::sleep_for(to_time(options_.rest));
  streams_ = false;
}

void Device::identify() {
  state_ = DeviceState::kIdentifying;
  if (line_->is_serial()) end_stream();  // a sensor that was left streaming does so after power-up
  std::array<std::uint16_t, 3> firmware{};
  line_->read(registers::kFirmware, firmware);
  const std::string text = firmware_text(firmware);
  if (!is_force_sensor(firmware)) {
    throw ModbusError(line_->name() + ": unit " + std::to_string(options_.unit) + " says '" + text +
                          "', which is no FT 300",
                      false);
  }
  {
    const std::lock_guard lock(mutex_);
    firmware_ = text;
  }
  streams_ = options_.stream && line_->is_serial();
  {
    const std::lock_guard lock(mutex_);
    discarded_before_ += stream_.discarded();
    ++statistics_.connections;
  }
  stream_ = StreamDecoder();
  if (streams_) {
    const std::uint16_t start[] = {registers::kStartStream};
    line_->write(registers::kOutputSelect, start);
  }
  note_(false, text + " on " + line_->name() + (streams_ ? ", streaming" : ", polled"));
  last_measurement_ = window_begin_ = next_poll_ = steady_now();
  window_count_ = 0;
}

void Device::measure() {
  if (streams_) {
    read_stream();
  } else {
    poll();
  }
  if (steady_now() - last_measurement_ <= to_time(options_.stale_time)) return;
  char words[64];
  std::snprintf(words, sizeof words, ": no measurement for %g s", options_.stale_time);
  throw ModbusError(line_->name() + words, false);
}

void Device::read_stream() {
  stream_.add(line_->read_bytes(kTick));
  while (const auto measurement = stream_.next()) take(*measurement);
  const std::lock_guard lock(mutex_);
  statistics_.discarded = discarded_before_ + stream_.discarded();
}

void Device::poll() {
  const Time now = steady_now();
  if (now < next_poll_) std::this_thread::sleep_for(next_poll_ - now);
  next_poll_ = std::max(next_poll_ + to_time(1 / options_.rate), now);
  MeasurementRegisters values{};
  try {
    line_->read(registers::kForce, values);
  } catch (const ModbusError& error) {
    if (error.closed) throw;
    const std::lock_guard lock(mutex_);
    ++statistics_.failures;  // a single one is no loss yet
    return;
  }
  take(from_registers(values));
}

void Device::take(const Measurement& measurement) {
  const Time now = steady_now();
  last_measurement_ = now;
  state_ = DeviceState::kMeasuring;
  ++window_count_;
  {
    const std::lock_guard lock(mutex_);
    ++statistics_.measurements;
    trouble_.clear();
    if (now - window_begin_ >= std::chrono::seconds(1)) {
      statistics_.rate = static_cast<double>(window_count_) / to_seconds(now - window_begin_);
      window_begin_ = now;
      window_count_ = 0;
    }
  }
  on_measurement_(measurement);
}

}  // namespace prehend::drivers::ft300
