#pragma once

#include "drivers/barrett/driver/gcl/driver.h"
#include "drivers/wire/hand/hand_device.h"
#include "drivers/wire/hand/stream_port.h"

namespace prehend::drivers::barrett::gcl {

/// A Driver that lives, on a serial line. At its end it sends zero velocities and Ctrl-C. What the
/// hand holds stays held: the worm gears of the fingers need no motor.
class Device : public WiredHand<Driver, StreamPort, HandDriver> {
 public:
  /// As WiredHand::Callbacks; `open` opens the line at DriverOptions::baud.
  Device(const DriverOptions& options, Open open, OnState on_state, Note note, double retry = 0.5,
         OnRound on_round = {});
};

}  // namespace prehend::drivers::barrett::gcl
