#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "drivers/wire/hand/port_event.h"
#include "drivers/wire/stream/byte_stream.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers {

/// An open stream, as the thread of a hand's driver serves it: waits for input without holding up
/// who commands, then passes it on.
class StreamPort {
 public:
  using Line = ByteStream;
  explicit StreamPort(std::unique_ptr<ByteStream> line) : line_(std::move(line)) {}

  const std::string& name() const { return line_->name(); }
  ByteStream& line() { return *line_; }
  /// "" or why it could not.
  std::string send(Bytes bytes) {
    constexpr auto kWriteTime = std::chrono::milliseconds(50);
    const IoResult result = line_->write(bytes, kWriteTime);
    return result.status == IoStatus::kOk ? std::string() : result.problem;
  }
  void wait(std::chrono::nanoseconds most) { result_ = line_->read(buffer_, most); }
  /// `on_event(PortEvent, words)` returns false when the port was left.
  template <class Driver, class OnEvent>
  void pass_on(Driver& driver, const OnEvent& on_event) {
    if (result_.status == IoStatus::kClosed) {
      on_event(PortEvent::kClosed, result_.problem);
    } else if (result_.count > 0) {
      driver.receive(Bytes(buffer_).first(result_.count), steady_now());
    }
  }

 private:
  std::unique_ptr<ByteStream> line_;
  std::array<std::uint8_t, 4096> buffer_{};
  IoResult result_;
};

}  // namespace prehend::drivers
