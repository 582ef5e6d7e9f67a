#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/sdh/codec/codes.h"
#include "drivers/wire/encoding/byte_order.h"

/// The binary form, of firmware 0.0.2.15 and later: a first byte of 0x80 or more begins one. Always
/// all seven axes. On RS-232 each message ends in the CRC of crc16_weiss(), on TCP and CAN in none
/// (SDHLibrary-CPP, sdhserial.cpp).
namespace prehend::drivers::sdh {

inline constexpr std::uint8_t kFirstBinary = 0x80;

struct BinaryRequest {
  std::uint8_t command = 0;               // Command
  std::optional<AxisValues> values = {};  // none: it asks

  friend bool operator==(const BinaryRequest&, const BinaryRequest&) = default;
};

struct BinaryReply {
  std::uint8_t command = 0;    // Command
  std::uint8_t count = kAxes;  // of values that mean something
  std::uint8_t status = 0;     // ReturnCode
  AxisValues values{};         // binary32 on the wire; may be no finite numbers

  bool has_values() const { return status == 0 && count == kAxes; }
};

std::vector<std::uint8_t> encode(const BinaryRequest& request, bool has_checksum);
std::vector<std::uint8_t> encode(const BinaryReply& reply, bool has_checksum);

/// Bytes of a message that begins with these two; 0: none does.
std::size_t request_size(std::uint8_t command, std::uint8_t length, bool has_checksum);
std::size_t reply_size(std::uint8_t command, std::uint8_t length, bool has_checksum);

/// Of a whole message, checksum and all. Nothing when it is none, or damaged.
std::optional<BinaryRequest> decode_binary_request(Bytes bytes, bool has_checksum);
std::optional<BinaryReply> decode_binary_reply(Bytes bytes, bool has_checksum);

}  // namespace prehend::drivers::sdh
