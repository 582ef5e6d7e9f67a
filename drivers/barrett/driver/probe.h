#pragma once

#include <chrono>
#include <string>

#include "drivers/barrett/codec/puck.h"
#include "drivers/wire/probe/probe.h"

namespace prehend::drivers::barrett {

/// Asks the four pucks of the hand on this bus for version, status and temperature, which moves
/// nothing and changes nothing. It first listens for 0.1 s, and where somebody talks to the hand it
/// asks nothing. Costs up to 2 * patience when nobody answers.
/// @throws geometry::InputError as open_can_bus.
Probe probe(const std::string& bus, unsigned bit_rate = kBitRate,
            std::chrono::nanoseconds patience = std::chrono::milliseconds(300));

}  // namespace prehend::drivers::barrett
