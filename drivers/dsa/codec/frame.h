#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/wire/encoding/byte_order.h"

namespace prehend::drivers::dsa {

/// The pressures of all matrices at one instant. Texels of the matrices follow one another; within
/// a matrix row by row, x fastest.
struct Frame {
  std::uint32_t timestamp = 0;        // ms, the controller's clock; wraps after 49.7 days
  std::vector<std::uint16_t> texels;  // counts, 0..4095
  friend bool operator==(const Frame&, const Frame&) = default;
};

inline constexpr std::uint16_t kFullScale = 4095;  // 12 bit

/// Payload of packet 0x00: timestamp (u32), flags (u8, bit 0: run-length coded), texels. Raw: one
/// u16 a texel. Run-length coded: u16 units of a 12-bit value and a 4-bit run of 1..15, runs going
/// on across rows and matrices. The latter is never longer than raw.
/// @throws std::invalid_argument for a texel above 4095.
std::vector<std::uint8_t> encode_frame(const Frame& frame, bool run_length);

/// Fills `frame` (its memory is used again). False, with `frame` unspecified, when the payload does
/// not hold exactly `texels` texels: cut off, too long, a run of 0 or a raw value above 4095. Flags
/// other than bit 0 are not looked at: what they mean is not known.
bool decode_frame(Bytes payload, std::size_t texels, Frame& frame);

}  // namespace prehend::drivers::dsa
