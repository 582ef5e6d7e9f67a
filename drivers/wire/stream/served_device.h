#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "drivers/wire/stream/byte_stream.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers {

/// An emulated device that lives behind a stream: a thread reads, answers and keeps time.
/// `Emulated` has receive(Bytes, Time) and update(Time), and is made with a function that takes its
/// bytes.
template <class Emulated>
class ServedDevice {
 public:
  template <class Options>
  ServedDevice(const Options& options, std::unique_ptr<ByteStream> line)
      : line_(std::move(line)),
        // What cannot be written is lost, as on a real wire; the driver notices.
        device_(options, [this](Bytes bytes) { line_->write(bytes, kWriteTime); }),
        thread_([this] { run(); }) {}
  ~ServedDevice() {
    ends_ = true;
    thread_.join();
  }

  /// Runs `work` on the device with the present time, between two messages.
  template <class Work>
  auto with_device(Work&& work) {
    const std::lock_guard lock(mutex_);
    return work(device_, steady_now());
  }
  /// Reads nothing from now on, so that the line's buffer fills up.
  void set_deaf(bool deaf) { deaf_ = deaf; }

 private:
  static constexpr auto kTick = std::chrono::milliseconds(1);
  static constexpr auto kWriteTime = std::chrono::milliseconds(20);

  void run() {
    std::array<std::uint8_t, 4096> buffer;
    while (!ends_) {
      IoResult result;
      if (deaf_) {
        std::this_thread::sleep_for(kTick);
      } else {
        result = line_->read(buffer, kTick);
      }
      if (result.status == IoStatus::kClosed) std::this_thread::sleep_for(kTick);
      const std::lock_guard lock(mutex_);
      const Time now = steady_now();
      if (result.count > 0) device_.receive(Bytes(buffer).first(result.count), now);
      device_.update(now);
    }
  }

  std::mutex mutex_;  // guards device_
  std::unique_ptr<ByteStream> line_;
  Emulated device_;
  std::atomic<bool> deaf_ = false;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers
