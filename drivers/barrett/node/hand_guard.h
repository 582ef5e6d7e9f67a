#pragma once

#include <string>

#include "drivers/barrett/driver/driver.h"
#include "drivers/wire/guardian/guard.h"
#include "drivers/wire/guardian/guardian.h"

namespace prehend::drivers::barrett {

/// The program barrett_guardian for the hand on this bus.
GuardianProgram guardian_program(const std::string& bus, unsigned bit_rate);
/// Of a hand with this reading.
Watch watch_of(const Reading& reading);
/// What the program does: MODE 0 to each puck until all show it, after three times CMD T (motor
/// off) too. With a bus of its own: that of a driver that hangs does not hinder it.
Guarding guarding(const std::string& bus, unsigned bit_rate);

}  // namespace prehend::drivers::barrett
