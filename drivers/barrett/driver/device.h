#pragma once

#include <memory>
#include <string>

#include "drivers/barrett/driver/driver.h"
#include "drivers/wire/can/can_bus.h"
#include "drivers/wire/hand/bus_port.h"
#include "drivers/wire/hand/hand_device.h"

namespace prehend::drivers::barrett {

/// The bus of a hand, as the host hears it: "can0", "slcan:/dev/ttyACM0"; `bit_rate` as
/// open_can_bus. @throws geometry::InputError as that.
std::unique_ptr<CanBus> open_hand_bus(const std::string& name, unsigned bit_rate);

/// A Driver that lives, on a bus. At its end it stops the hand. What it holds stays held: the worm
/// gears of the fingers need no motor.
class Device : public WiredHand<Driver, BusPort, HandDriver> {
 public:
  /// As WiredHand::Callbacks; `on_pad` is called by the thread.
  Device(const DriverOptions& options, Open open, OnState on_state, Note note, double retry = 0.5,
         OnRound on_round = {}, Driver::OnPad on_pad = {});
};

}  // namespace prehend::drivers::barrett
