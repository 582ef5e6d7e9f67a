#pragma once

#include "drivers/pg70/driver/driver.h"
#include "drivers/pg70/transport/link.h"
#include "drivers/wire/guardian/guard.h"
#include "drivers/wire/guardian/guardian.h"

namespace prehend::drivers::pg70 {

/// The program pg70_guardian for this gripper.
GuardianProgram guardian_program(const LinkAddress& address);
/// Of a gripper with this reading.
Watch watch_of(const Reading& reading);
/// What the program does: CMD STOP until it is answered, CMD FAST STOP too when it is not.
Guarding guarding(const LinkAddress& address);

}  // namespace prehend::drivers::pg70
