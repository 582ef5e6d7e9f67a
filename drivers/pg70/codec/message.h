#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "drivers/wire/encoding/byte_order.h"

namespace prehend::drivers::pg70 {

/// Where a message of the Schunk Motion Protocol (SMP) comes from. On CAN it is in the upper bits
/// of the identifier, on RS-232 in the first byte.
enum class Direction : std::uint8_t {
  kCommand,   ///< master to module: CAN 0x500 + id, RS-232 0x05
  kResponse,  ///< module to master, impulse messages included: 0x700 + id, 0x07
  kError,     ///< module to master, CMD ERROR and CMD WARNING: 0x300 + id, 0x03
};

/// What D-Len counts: the command code and its parameters, at most 255 bytes, without any
/// transport. A value without allocation.
class Content {
 public:
  static constexpr std::size_t kMostBytes = 255;

  Content() = default;
  /// @throws std::length_error beyond kMostBytes.
  explicit Content(Bytes bytes) { append(bytes); }

  /// The command code; 0 when empty.
  std::uint8_t command() const { return size_ > 0 ? bytes_[0] : std::uint8_t{0}; }
  std::size_t size() const { return size_; }  // D-Len
  Bytes bytes() const { return {bytes_.data(), size_}; }
  Bytes parameters() const { return bytes().subspan(std::min<std::size_t>(1, size_)); }

  /// @throws std::length_error beyond kMostBytes.
  void append(Bytes bytes) {
    if (bytes.size() > kMostBytes - size_) throw std::length_error("SMP message beyond 255 bytes");
    std::copy(bytes.begin(), bytes.end(), bytes_.begin() + size_);
    size_ = static_cast<std::uint8_t>(size_ + bytes.size());
  }
  template <class Number>
  void append_number(Number value) {
    std::uint8_t bytes[sizeof value];
    store_little(bytes, value);
    append(bytes);
  }
  void clear() { size_ = 0; }

  friend bool operator==(const Content& a, const Content& b) {
    return std::ranges::equal(a.bytes(), b.bytes());
  }

 private:
  std::array<std::uint8_t, kMostBytes> bytes_{};
  std::uint8_t size_ = 0;
};

}  // namespace prehend::drivers::pg70
