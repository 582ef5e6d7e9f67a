#pragma once

#include <chrono>
#include <string>

#include "drivers/wire/probe/probe.h"

namespace prehend::drivers::dsa {

/// Asks the tactile controller on `line` who it is (packets 0x01 and 0x02, which change nothing).
/// It first listens for 0.15 s: a controller that streams already is not asked. Takes up to
/// `patience` when nobody answers.
/// @throws geometry::InputError as open_byte_stream.
Probe probe(const std::string& line, unsigned baud = 115200,
            std::chrono::nanoseconds patience = std::chrono::seconds(2));

}  // namespace prehend::drivers::dsa
