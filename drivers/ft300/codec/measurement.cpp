#include "drivers/ft300/codec/measurement.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "drivers/wire/encoding/checksum.h"

namespace prehend::drivers::ft300 {
namespace {

constexpr double kPerNewton = 100, kPerNewtonMetre = 1000;
constexpr std::array<std::uint8_t, 2> kStreamBegin = {0x20, 0x4E};
constexpr std::size_t kChecksumAt = kStreamMessageSize - 2;

std::uint16_t scaled(double value, double scale) {
  if (std::isnan(value)) return 0;
  const double counts = std::clamp(std::round(value * scale), -32768.0, 32767.0);
  return static_cast<std::uint16_t>(static_cast<std::int16_t>(counts));
}

char high(std::uint16_t value) { return static_cast<char>(value >> 8); }
char low(std::uint16_t value) { return static_cast<char>(value & 0xFF); }
char printable(char c) { return c >= ' ' && c <= '~' ? c : '?'; }

}  // namespace

MeasurementRegisters to_registers(const Measurement& measurement) {
  MeasurementRegisters values{};
  for (std::size_t i = 0; i < 3; ++i) {
    values[i] = scaled(measurement.force[i], kPerNewton);
    values[i + 3] = scaled(measurement.torque[i], kPerNewtonMetre);
  }
  return values;
}

Measurement from_registers(const MeasurementRegisters& values) {
  Measurement measurement;
  for (std::size_t i = 0; i < 3; ++i) {
    measurement.force[i] = static_cast<std::int16_t>(values[i]) / kPerNewton;
    measurement.torque[i] = static_cast<std::int16_t>(values[i + 3]) / kPerNewtonMetre;
  }
  return measurement;
}

std::string firmware_text(const std::array<std::uint16_t, 3>& values) {
  char text[32];
  std::snprintf(text, sizeof text, "%c%c%c-%u.%u.%u", printable(high(values[0])),
                printable(low(values[0])), printable(high(values[1])),
                static_cast<unsigned>(values[1] & 0xFF), static_cast<unsigned>(values[2] >> 8),
                static_cast<unsigned>(values[2] & 0xFF));
  return text;
}

bool is_force_sensor(const std::array<std::uint16_t, 3>& firmware) {
  return high(firmware[0]) == 'F';
}

std::string serial_text(const std::array<std::uint16_t, 4>& values) {
  char text[32];
  std::snprintf(text, sizeof text, "%c%c%c-%08u", printable(high(values[0])),
                printable(low(values[0])), printable(high(values[1])),
                static_cast<unsigned>(values[3]) << 16 | values[2]);
  return text;
}

std::array<std::uint8_t, kStreamMessageSize> encode_stream(const Measurement& measurement) {
  std::array<std::uint8_t, kStreamMessageSize> bytes{};
  std::copy(kStreamBegin.begin(), kStreamBegin.end(), bytes.begin());
  const MeasurementRegisters values = to_registers(measurement);
  for (std::size_t i = 0; i < values.size(); ++i) store_little(&bytes[2 + 2 * i], values[i]);
  store_little(&bytes[kChecksumAt], crc16_reflected_8005(Bytes(bytes).first(kChecksumAt), 0xFFFF));
  return bytes;
}

void StreamDecoder::add(Bytes bytes) { append_bytes(buffer_, bytes); }

std::optional<Measurement> StreamDecoder::next() {
  std::size_t begin = 0;
  std::optional<Measurement> found;
  for (; begin < buffer_.size(); ++begin) {
    const std::size_t available = buffer_.size() - begin;
    if (!std::equal(buffer_.begin() + static_cast<std::ptrdiff_t>(begin),
                    buffer_.begin() + static_cast<std::ptrdiff_t>(
                                          begin + std::min(available, kStreamBegin.size())),
                    kStreamBegin.begin())) {
      continue;
    }
    if (available < kStreamMessageSize) break;
    const Bytes message = Bytes(buffer_).subspan(begin, kStreamMessageSize);
    if (crc16_reflected_8005(message.first(kChecksumAt), 0xFFFF) !=
        load_little<std::uint16_t>(&message[kChecksumAt])) {
      continue;
    }
    MeasurementRegisters values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = load_little<std::uint16_t>(&message[2 + 2 * i]);
    }
    found = from_registers(values);
    break;
  }
  discarded_ += begin;
  const std::size_t end = begin + (found ? kStreamMessageSize : 0);
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(end));
  return found;
}

}  // namespace prehend::drivers::ft300
