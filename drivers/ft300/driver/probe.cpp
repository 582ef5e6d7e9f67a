#include "drivers/ft300/driver/probe.h"

#include <array>
#include <chrono>
#include <cstdio>
#include <optional>

#include "drivers/ft300/codec/measurement.h"
#include "drivers/ft300/transport/modbus_line.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::ft300 {
namespace {

constexpr auto kListening = std::chrono::milliseconds(150);  // 15 messages of a stream

std::string text_of(const Measurement& measurement) {
  std::array<char, 64> text{};
  const auto& force = measurement.force;
  std::snprintf(text.data(), text.size(), "(%.2f, %.2f, %.2f) N", force[0], force[1], force[2]);
  return text.data();
}

Probe ask(ModbusLine& modbus, const std::string& who, std::uint8_t unit) {
  std::array<std::uint16_t, 3> firmware{};
  modbus.read(registers::kFirmware, firmware);
  if (!is_force_sensor(firmware)) {
    return {Probe::Result::kSilent,
            "unit " + std::to_string(unit) + " on " + modbus.name() + " says '" +
                firmware_text(firmware) + "', which is no FT 300",
            "another Modbus device has this address: ft300:= names the line"};
  }
  MeasurementRegisters values{};
  modbus.read(registers::kForce, values);
  return {Probe::Result::kAnswers,
          who + " answers: " + firmware_text(firmware) + ", measures " +
              text_of(from_registers(values)) + " before taring",
          {}};
}

}  // namespace

Probe probe(const std::string& line, unsigned baud, std::uint8_t unit, double reply_time) {
  ModbusLine modbus(line, baud, unit,
                    std::chrono::microseconds(static_cast<std::int64_t>(reply_time * 1e6)));
  const std::string who = "force sensor on " + line;
  std::size_t bytes = 0;
  try {
    if (modbus.is_serial()) {
      StreamDecoder stream;
      const Time end = steady_now() + kListening;
      for (Time now = steady_now(); now < end; now = steady_now()) {
        const auto heard = modbus.read_bytes(end - now);
        bytes += heard.size();
        stream.add(heard);
        if (const auto measurement = stream.next()) {
          return {Probe::Result::kAnswers, who + " streams: " + text_of(*measurement), {}};
        }
      }
    }
    return ask(modbus, who, unit);
  } catch (const ModbusError& error) {
    Probe probe{Probe::Result::kSilent,
                "the force sensor does not answer: " + std::string(error.what()),
                "check its supply, the two wires of RS-485 (exchanged?), that it is unit " +
                    std::to_string(unit) + " at " + std::to_string(baud) + " bit/s"};
    if (!modbus.is_serial()) probe.mend = "check the line between gateway and sensor, and the unit";
    if (bytes > 0) {
      probe.what += "; what comes is not its stream";
      probe.mend = "another device or another bit rate: " + probe.mend;
    }
    return probe;
  }
}

}  // namespace prehend::drivers::ft300
