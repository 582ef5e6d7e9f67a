#pragma once

#include <cstdint>

#include "drivers/wire/encoding/byte_order.h"

namespace prehend::drivers {

/// CRC-16 with the reflected polynomial 0x8005 (0xA001), no final XOR.
/// `initial` 0x0000 is CRC-16/ARC ("123456789" -> 0xBB3D), as the Schunk Motion Protocol uses it on
/// RS-232 (manual V1.41, page 304); 0xFFFF is CRC-16/MODBUS ("123456789" -> 0x4B37), as Modbus RTU
/// and the stream of the Robotiq FT 300 do. To go on after an earlier part give its result.
/// Cost: about 0.5 ns a byte.
std::uint16_t crc16_reflected_8005(Bytes bytes, std::uint16_t initial);

/// The CRC of Weiss Robotics (DSACON32-m, WSG): start 0xFFFF, the table of the MSB-first polynomial
/// 0x1021, but an update that shifts right: crc = (crc >> 8) ^ table[(crc ^ byte) & 0xFF]. No final
/// XOR. Neither CRC-16/CCITT-FALSE nor MCRF4XX: "123456789" -> 0x6EB4. Source: SDHLibrary-CPP
/// (Schunk), sdh/crc.h, and the Weiss checksum routine of the WSG 50, which agree.
std::uint16_t crc16_weiss(Bytes bytes);

}  // namespace prehend::drivers
