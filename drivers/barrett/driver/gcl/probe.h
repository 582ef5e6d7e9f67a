#pragma once

#include <chrono>
#include <string>

#include "drivers/wire/probe/probe.h"

namespace prehend::drivers::barrett::gcl {

/// Asks a BH8-262 at `line` for its firmware, status and temperature, which moves nothing and
/// changes nothing, at 9600 baud and then at the other rates that it may have stored. It first
/// listens for 0.15 s. Costs up to 8 * patience when nobody answers.
/// @throws geometry::InputError as open_byte_stream.
Probe probe(const std::string& line,
            std::chrono::nanoseconds patience = std::chrono::milliseconds(500));

}  // namespace prehend::drivers::barrett::gcl
