#include "drivers/wire/encoding/checksum.h"

#include <gtest/gtest.h>

#include <random>
#include <string_view>
#include <vector>

namespace prehend::drivers {
namespace {

Bytes bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// The polynomials bit by bit, as the definitions have them.
std::uint16_t reflected_by_bits(Bytes bytes, unsigned crc) {
  for (const unsigned byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) ? (crc >> 1) ^ 0xA001u : crc >> 1;
  }
  return static_cast<std::uint16_t>(crc);
}

// SDHLibrary's update, its table entry by entry.
std::uint16_t weiss_by_bits(Bytes bytes) {
  unsigned crc = 0xFFFF;
  for (const unsigned byte : bytes) {
    unsigned entry = ((crc ^ byte) & 0xFF) << 8;
    for (int bit = 0; bit < 8; ++bit)
      entry = (entry & 0x8000u) ? (entry << 1) ^ 0x1021u : entry << 1;
    crc = (crc >> 8) ^ (entry & 0xFFFF);
  }
  return static_cast<std::uint16_t>(crc);
}

TEST(Checksum, CheckValuesOfTheCatalogue) {
  const Bytes digits = bytes_of("123456789");
  EXPECT_EQ(crc16_reflected_8005(digits, 0x0000), 0xBB3D);  // CRC-16/ARC
  EXPECT_EQ(crc16_reflected_8005(digits, 0xFFFF), 0x4B37);  // CRC-16/MODBUS
  EXPECT_EQ(crc16_weiss(digits), 0x6EB4);
  EXPECT_EQ(crc16_weiss({}), 0xFFFF);
}

TEST(Checksum, AgreesWithTheDefinitionAndGoesOnAfterAnEarlierPart) {
  std::mt19937 random(1);
  for (int run = 0; run < 2000; ++run) {
    std::vector<std::uint8_t> bytes(random() % 64);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    const std::uint16_t whole = crc16_reflected_8005(bytes, 0xFFFF);
    ASSERT_EQ(whole, reflected_by_bits(bytes, 0xFFFF));
    ASSERT_EQ(crc16_weiss(bytes), weiss_by_bits(bytes));
    const std::size_t cut = bytes.empty() ? 0 : random() % bytes.size();
    const std::uint16_t first = crc16_reflected_8005(Bytes(bytes).first(cut), 0xFFFF);
    ASSERT_EQ(crc16_reflected_8005(Bytes(bytes).subspan(cut), first), whole);
  }
}

TEST(Checksum, FindsEverySingleAndDoubleBitErrorOfAShortMessage) {
  const std::vector<std::uint8_t> bytes(14, 0x5A);
  const std::size_t bits = bytes.size() * 8;
  const auto flip = [](std::vector<std::uint8_t>& b, std::size_t bit) {
    b[bit / 8] = static_cast<std::uint8_t>(b[bit / 8] ^ (1u << bit % 8));
  };
  for (std::size_t i = 0; i < bits; ++i) {
    for (std::size_t j = i; j < bits; ++j) {
      auto damaged = bytes;
      flip(damaged, i);
      if (j != i) flip(damaged, j);
      ASSERT_NE(crc16_reflected_8005(damaged, 0), crc16_reflected_8005(bytes, 0)) << i << ' ' << j;
    }
  }
}

}  // namespace
}  // namespace prehend::drivers
