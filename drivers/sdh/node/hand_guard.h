#pragma once

#include <string>

#include "drivers/sdh/driver/driver.h"
#include "drivers/wire/guardian/guard.h"
#include "drivers/wire/guardian/guardian.h"
#include "drivers/wire/hand/hand_watch.h"

namespace prehend::drivers::sdh {

/// The program sdh_guardian for the hand on this line.
GuardianProgram guardian_program(const std::string& line, unsigned baud);
/// What the program does: `stop` until it is answered, after three times `power` off with each. A
/// hand over TCP serves one computer: it is reached once the driver's connection is closed, which
/// that of a driver that hangs is not.
Guarding guarding(const std::string& line, unsigned baud);

}  // namespace prehend::drivers::sdh
