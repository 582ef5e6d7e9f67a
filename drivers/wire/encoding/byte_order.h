#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

namespace prehend::drivers {

static_assert(std::endian::native == std::endian::little,
              "numbers are stored as they lie in memory");

/// Bytes of a message that somebody else owns.
using Bytes = std::span<const std::uint8_t>;

/// The little-endian number at `bytes` (sizeof(Number) of them): integers and IEEE-754 floats.
template <class Number>
Number load_little(const std::uint8_t* bytes) {
  static_assert(std::is_arithmetic_v<Number>);
  Number value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

template <class Number>
void store_little(std::uint8_t* bytes, Number value) {
  static_assert(std::is_arithmetic_v<Number>);
  std::memcpy(bytes, &value, sizeof value);
}

/// Appends bytes to a vector. (std::vector::insert makes GCC 12 warn of overflows that cannot be.)
template <class Container>
void append_bytes(Container& container, Bytes bytes) {
  const std::size_t end = container.size();
  container.resize(end + bytes.size());
  std::copy(bytes.begin(), bytes.end(), container.begin() + static_cast<std::ptrdiff_t>(end));
}

/// Appends the number to a vector of bytes, little-endian.
template <class Number, class Container>
void append_little(Container& container, Number value) {
  std::uint8_t bytes[sizeof value];
  store_little(bytes, value);
  append_bytes(container, bytes);
}

/// Takes numbers off the front of a message. Beyond its end everything is 0 and ok() is false, so
/// that a structure can be read first and judged once.
class ByteReader {
 public:
  explicit ByteReader(Bytes bytes) : bytes_(bytes) {}

  template <class Number>
  Number take() {
    if (bytes_.size() < sizeof(Number)) {
      bytes_ = {};
      ok_ = false;
      return Number{};
    }
    const Number value = load_little<Number>(bytes_.data());
    bytes_ = bytes_.subspan(sizeof(Number));
    return value;
  }
  /// Copies `count` bytes to `target`; fewer leave it untouched.
  void take(std::uint8_t* target, std::size_t count) {
    if (bytes_.size() < count) {
      bytes_ = {};
      ok_ = false;
      return;
    }
    std::copy_n(bytes_.data(), count, target);
    bytes_ = bytes_.subspan(count);
  }
  Bytes rest() const { return bytes_; }
  bool ok() const { return ok_; }
  /// True when all was there and nothing is left over.
  bool complete() const { return ok_ && bytes_.empty(); }

 private:
  Bytes bytes_;
  bool ok_ = true;
};

}  // namespace prehend::drivers
