#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/wire/encoding/byte_order.h"

namespace prehend::drivers::ft300 {

/// What the sensor measures, in its own frame. Resolution 0.01 N and 0.001 N m; what fits the wire
/// is +-327.67 N and +-32.767 N m.
struct Measurement {
  std::array<double, 3> force{};   // N
  std::array<double, 3> torque{};  // N m
  friend bool operator==(const Measurement&, const Measurement&) = default;
};

/// Modbus holding registers, protocol addresses (Robotiq FT 300 manual, page 65; addresses on the
/// wire after ros-industrial-attic/robotiq, rq_sensor_com.cpp).
namespace registers {
inline constexpr std::uint16_t kForce = 180;         // x, y, z, signed, 1/100 N
inline constexpr std::uint16_t kTorque = 183;        // x, y, z, signed, 1/1000 N m
inline constexpr std::uint16_t kAcceleration = 190;  // x, y, z, signed, 1/1000 g
inline constexpr std::uint16_t kOutputSelect = 410;  // write kStartStream
inline constexpr std::uint16_t kFirmware = 500;      // 3 registers: 3 letters, 3 numbers
inline constexpr std::uint16_t kSerial = 510;        // 4 registers
inline constexpr std::uint16_t kYear = 514;
inline constexpr std::uint16_t kStartStream = 0x0200;
}  // namespace registers

using MeasurementRegisters = std::array<std::uint16_t, 6>;

/// Registers 180..185. A value beyond what fits is cut to the end of the range; NaN becomes 0.
MeasurementRegisters to_registers(const Measurement& measurement);
Measurement from_registers(const MeasurementRegisters& values);

/// Firmware "FTS-2.0.1" from its three registers, each two bytes, the first one high.
std::string firmware_text(const std::array<std::uint16_t, 3>& values);
/// The sensor's models say 'F' first; other devices at the same address do not.
bool is_force_sensor(const std::array<std::uint16_t, 3>& firmware);
/// Serial number, e.g. "ABC-00012345", from registers 510..513 (layout after the vendor's driver).
std::string serial_text(const std::array<std::uint16_t, 4>& values);

/// Stream mode, 100 Hz: 20 4E | six little-endian signed 16 as in the registers | CRC-16/MODBUS.
inline constexpr std::size_t kStreamMessageSize = 16;
std::array<std::uint8_t, kStreamMessageSize> encode_stream(const Measurement& measurement);

/// Finds stream messages in bytes that may begin anywhere and hold garbage. A false beginning costs
/// one byte.
class StreamDecoder {
 public:
  void add(Bytes bytes);
  std::optional<Measurement> next();
  std::uint64_t discarded() const { return discarded_; }  // bytes that belonged to no message

 private:
  std::vector<std::uint8_t> buffer_;
  std::uint64_t discarded_ = 0;
};

}  // namespace prehend::drivers::ft300
