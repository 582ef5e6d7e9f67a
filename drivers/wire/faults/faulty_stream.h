#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "drivers/wire/faults/faulty_line.h"
#include "drivers/wire/stream/byte_stream.h"

namespace prehend::drivers {

/// A stream whose writes suffer, each as a whole. Late ones leave when read() or write() is called
/// next.
class FaultyStream : public ByteStream {
 public:
  explicit FaultyStream(std::unique_ptr<ByteStream> stream, std::uint64_t seed = 1)
      : stream_(std::move(stream)), line_(&corrupt, seed) {}

  void set_faults(const LineFaults& faults) {
    const std::lock_guard lock(mutex_);
    line_.set_faults(faults);
  }
  IoResult read(std::span<std::uint8_t> buffer, std::chrono::nanoseconds timeout) override {
    deliver(timeout);
    return stream_->read(buffer, timeout);
  }
  IoResult write(Bytes bytes, std::chrono::nanoseconds timeout) override {
    {
      const std::lock_guard lock(mutex_);
      line_.push({bytes.begin(), bytes.end()}, steady_now());
    }
    deliver(timeout);
    return {IoStatus::kOk, bytes.size(), {}};
  }
  const std::string& name() const override { return stream_->name(); }

 private:
  using Block = std::vector<std::uint8_t>;
  static void corrupt(Block& block, std::mt19937_64& random) {
    if (!block.empty())
      block[random() % block.size()] ^= static_cast<std::uint8_t>(1 << random() % 8);
  }
  void deliver(std::chrono::nanoseconds timeout) {
    const std::lock_guard lock(mutex_);
    while (const auto block = line_.pop(steady_now())) stream_->write(*block, timeout);
  }

  std::unique_ptr<ByteStream> stream_;
  std::mutex mutex_;
  FaultyLine<Block> line_;
};

}  // namespace prehend::drivers
