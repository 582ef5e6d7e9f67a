#include "drivers/dsa/driver/device.h"

#include <array>
#include <utility>

namespace prehend::drivers::dsa {
namespace {

constexpr auto kTick = std::chrono::milliseconds(20);
constexpr auto kWriteTime = std::chrono::milliseconds(50);

}  // namespace

Device::Device(const DriverOptions& options, Open open, OnFrame on_frame, Driver::Note note,
               double retry)
    : open_(std::move(open)),
      reopening_(retry, note),
      driver_(
          options,
          [this](Bytes bytes) -> std::string {
            const IoResult result = line_->write(bytes, kWriteTime);
            return result.status == IoStatus::kOk ? std::string() : result.problem;
          },
          [this, on_frame = std::move(on_frame)](const Frame& frame) {
            on_frame(frame, driver_.matrices());
          },
          std::move(note)),
      thread_([this] { run(); }) {}

Device::~Device() {
  ends_ = true;
  thread_.join();
}

DriverState Device::state() {
  const std::lock_guard lock(mutex_);
  return driver_.state();
}

Statistics Device::statistics() {
  const std::lock_guard lock(mutex_);
  return driver_.statistics();
}

std::string Device::trouble() {
  const std::lock_guard lock(mutex_);
  return line_problem_.empty() ? driver_.trouble() : line_problem_;
}

void Device::open_line() {
  line_ = reopening_.attempt(open_, kTick);
  const std::lock_guard lock(mutex_);
  line_problem_ = reopening_.problem();
  if (!line_) return;
  driver_.connected(steady_now());
}

void Device::run() {
  std::array<std::uint8_t, 4096> buffer;
  while (!ends_) {
    if (!line_) {
      open_line();
      continue;
    }
    const IoResult result = line_->read(buffer, kTick);
    const std::lock_guard lock(mutex_);
    const Time now = steady_now();
    if (result.status == IoStatus::kClosed) {
      driver_.disconnected(line_->name() + " is gone: " + result.problem);
      line_.reset();
      continue;
    }
    if (result.count > 0) driver_.receive(Bytes(buffer).first(result.count), now);
    driver_.update(now);
  }
  if (line_) driver_.stop(steady_now());
}

}  // namespace prehend::drivers::dsa
