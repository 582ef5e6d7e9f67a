#pragma once

#include <string>

#include "drivers/pg70/driver/driver.h"
#include "drivers/pg70/transport/link.h"
#include "drivers/wire/health/health.h"

namespace prehend::drivers::pg70 {

/// What is known of a gripper at one moment.
struct Situation {
  Reading reading;
  LinkAddress address;
  std::string line_problem;   // Device::line_problem
  std::string obstacle;       // Driver::obstacle
  double connecting = 0;      // s that kConnecting lasts
  std::string link_problem;   // LinkQuality::problem
  std::string guard_problem;  // Guardian::News::problem
};

/// The health that follows: kFault, kLost, kDisconnected and a module that does not answer are
/// errors; what persists after an acknowledge, a missing reference, a bad line and a missing
/// guardian are warnings; else the name of the state.
Health health_of(const Situation& situation);

/// Of a gripper that was ready before: why it stands still by itself, or nobody can make it, so
/// that everything else is to stop; "": it does what it is told. CMD FAST STOP is somebody's who
/// asked for it, and no fault of the gripper.
std::string own_stop(const Reading& reading);

}  // namespace prehend::drivers::pg70
