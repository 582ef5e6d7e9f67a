#pragma once

#include <string>

#include "drivers/barrett/driver/hand_driver.h"
#include "drivers/wire/health/health.h"

namespace prehend::drivers::barrett {

/// What is known of a hand at one moment.
struct Situation {
  Model model = Model::kBh8_280;
  Reading reading;
  std::string line;           // its name
  std::string line_problem;   // Device::line_problem
  double connecting = 0;      // s that kConnecting lasts
  double hot = 60;            // degree Celsius that are told
  std::string link_problem;   // LinkQuality::problem
  std::string guard_problem;  // Guarded::problem
};

/// The health that follows: kFault, kLost, kDisconnected and a hand that does not answer are
/// errors; a hand that is not initialised, heat, a pad that fails, a missing guardian and a bad bus
/// are warnings; else the name of the state.
Health health_of(const Situation& situation);

/// Of a hand that was ready before: why it stands still by itself, or nobody can make it, so that
/// everything else is to stop; "": it does what it is told.
std::string own_stop(const Reading& reading);

}  // namespace prehend::drivers::barrett
