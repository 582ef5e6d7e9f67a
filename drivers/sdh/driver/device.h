#pragma once

#include "drivers/sdh/driver/driver.h"
#include "drivers/wire/hand/hand_device.h"
#include "drivers/wire/hand/stream_port.h"

namespace prehend::drivers::sdh {

/// A Driver that lives, over a stream of bytes. At its end it stops the hand, then switches its
/// axes off as the options say, unless it holds something.
class Device : public WiredHand<Driver, StreamPort> {
 public:
  /// As WiredHand::Callbacks.
  Device(const DriverOptions& options, Open open, OnState on_state, Note note, double retry = 0.5,
         OnRound on_round = {});
};

}  // namespace prehend::drivers::sdh
