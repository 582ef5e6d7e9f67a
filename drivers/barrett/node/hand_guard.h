#pragma once

#include <string>

#include "drivers/barrett/driver/driver.h"
#include "drivers/wire/guardian/guard.h"
#include "drivers/wire/guardian/guardian.h"
#include "drivers/wire/hand/hand_watch.h"

namespace prehend::drivers::barrett {

/// The first argument of barrett_guardian: a BH8-280 on a bus, a BH8-262 on a line.
inline constexpr const char *kByBus = "can", *kByLine = "gcl";

/// The program barrett_guardian for the hand on this bus.
GuardianProgram guardian_program(const std::string& bus, unsigned bit_rate);
/// What the program does: MODE 0 to each puck until all show it, after three times CMD T (motor
/// off) too. With a bus of its own: that of a driver that hangs does not hinder it.
Guarding guarding(const std::string& bus, unsigned bit_rate);

namespace gcl {

/// The same for a BH8-262 on this line; `fast_baud` is the rate that its driver agrees on with it,
/// 0: none.
GuardianProgram guardian_program(const std::string& line, unsigned baud, unsigned fast_baud);
/// What the program does: Ctrl-C until the prompt comes, at either rate in turn, after three times
/// T (motors off) too. It sends as many as a control block of RealTime mode may want yet.
Guarding guarding(const std::string& line, unsigned baud, unsigned fast_baud);

}  // namespace gcl

}  // namespace prehend::drivers::barrett
