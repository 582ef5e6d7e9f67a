#pragma once

#include "drivers/wire/guardian/guardian.h"

namespace prehend::drivers {

/// What a guardian is told of a hand with this reading: one that does not answer may move.
template <class Reading>
Watch watch_of(const Reading& reading) {
  if (!reading.is_connected()) return Watch::kOff;
  return reading.moving || !reading.is_answering() ? Watch::kMoving : Watch::kStanding;
}

}  // namespace prehend::drivers
