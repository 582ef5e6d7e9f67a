#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "drivers/wire/encoding/byte_order.h"

namespace prehend::drivers {

/// A classic CAN data frame with a standard (11-bit) identifier.
struct CanFrame {
  std::uint16_t identifier = 0;  // 0..0x7FF
  std::uint8_t size = 0;         // data bytes, 0..8 (DLC)
  std::array<std::uint8_t, 8> data{};

  Bytes bytes() const { return {data.data(), size}; }
  friend bool operator==(const CanFrame& a, const CanFrame& b) {
    return a.identifier == b.identifier && std::ranges::equal(a.bytes(), b.bytes());
  }
};

}  // namespace prehend::drivers
