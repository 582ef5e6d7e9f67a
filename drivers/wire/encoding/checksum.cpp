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

constexpr Table kReflected = reflected_table();
constexpr Table kWeiss = weiss_table();
static_assert(kWeiss[1] == 0x1021 && kWeiss[255] == 0x1EF0);  // SDHLibrary, sdh/crc.cpp

std::uint16_t right_shifting_crc(Bytes bytes, std::uint16_t crc, const Table& table) {
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
