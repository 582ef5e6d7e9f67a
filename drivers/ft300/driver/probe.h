#pragma once

#include <cstdint>
#include <string>

#include "drivers/wire/probe/probe.h"

namespace prehend::drivers::ft300 {

/// Asks the force sensor on `line` (as DeviceOptions::line) for its firmware and a measurement. It
/// first listens for 0.15 s on a serial line: a sensor that streams already is left alone. Takes
/// 0.15 s + `reply_time` when nobody answers.
/// @throws geometry::InputError as ModbusLine.
Probe probe(const std::string& line, unsigned baud = 19200, std::uint8_t unit = 9,
            double reply_time = 0.5);

}  // namespace prehend::drivers::ft300
