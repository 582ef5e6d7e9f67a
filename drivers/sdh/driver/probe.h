#pragma once

#include <chrono>
#include <string>

#include "drivers/wire/probe/probe.h"

namespace prehend::drivers::sdh {

inline constexpr unsigned kBaud = 115200;

/// Asks the hand at `line` for its firmware, states and temperatures, which moves nothing and
/// changes nothing. It first listens for 0.15 s. Costs up to 0.25 s + 2 * patience when nobody
/// answers; then it says what was heard instead.
/// @throws geometry::InputError as open_byte_stream.
Probe probe(const std::string& line, unsigned baud = kBaud,
            std::chrono::nanoseconds patience = std::chrono::seconds(1));

}  // namespace prehend::drivers::sdh
