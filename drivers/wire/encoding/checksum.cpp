#include "drivers/wire/encoding/checksum.h"

#include <array>

namespace prehend::drivers {
namespace {

using Table = std::array<std::uint16_t, 256>;

constexpr Table reflected_table() {
  Table table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) ? (crc >> 1) ^ 0xA001u : crc >> 1;
    table[byte] = static_cast<std::uint16_t>(crc);
  }
  return table;
}

constexpr Table weiss_table() {
  Table table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned crc = byte << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000u) ? (crc << 1) ^ 0x1021u : crc << 1;
    table[byte] = static_cast<std::uint16_t>(crc);
  }
  return table;
}

constexpr std::size_t kSlices = 8;
using Slices = std::array<Table, kSlices>;

// slices[k][byte]: what a byte has become of after k more zero bytes. The update is linear over
// bits, so eight bytes can be looked up at once (Kounavis and Berry, "A systematic approach to
// building high performance software-based CRC generators", ISCC 2005).
constexpr Slices slices_of(const Table& table) {
  Slices slices{};
  slices[0] = table;
  for (std::size_t k = 1; k < kSlices; ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint16_t before = slices[k - 1][byte];
      slices[k][byte] = static_cast<std::uint16_t>((before >> 8) ^ table[before & 0xFF]);
    }
  }
  return slices;
}

constexpr Slices kReflected = slices_of(reflected_table());
constexpr Slices kWeiss = slices_of(weiss_table());
static_assert(kWeiss[0][1] == 0x1021 && kWeiss[0][255] == 0x1EF0);  // SDHLibrary, sdh/crc.cpp

std::uint16_t right_shifting_crc(Bytes bytes, std::uint16_t crc, const Slices& slices) {
  for (; bytes.size() >= kSlices; bytes = bytes.subspan(kSlices)) {
    unsigned next = slices[7][(bytes[0] ^ crc) & 0xFF] ^ slices[6][bytes[1] ^ (crc >> 8)];
    for (std::size_t k = 2; k < kSlices; ++k) next ^= slices[kSlices - 1 - k][bytes[k]];
    crc = static_cast<std::uint16_t>(next);
  }
  const Table& table = slices[0];
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>((crc >> 8) ^ table[(crc ^ byte) & 0xFF]);
  }
  return crc;
}

}  // namespace

std::uint16_t crc16_reflected_8005(Bytes bytes, std::uint16_t initial) {
  return right_shifting_crc(bytes, initial, kReflected);
}

std::uint16_t crc16_weiss(Bytes bytes) { return right_shifting_crc(bytes, 0xFFFF, kWeiss); }

}  // namespace prehend::drivers
