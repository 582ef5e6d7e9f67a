#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "drivers/wire/can/can_frame.h"

namespace prehend::drivers {

/// What happened to a bus, apart from data.
struct CanEvent {
  enum class Kind {
    kDisturbed,      ///< errors on the wire; frames still pass
    kBusOff,         ///< the controller has left the bus: nothing is sent or received
    kRestarted,      ///< it is back on the bus, or free of errors again
    kInterfaceDown,  ///< nothing is sent or received until the interface is up again
    kClosed,         ///< the interface is gone; open the bus anew
  };
  Kind kind = Kind::kDisturbed;
  std::string words;  // one line
};

using CanInput = std::variant<CanFrame, CanEvent>;

/// A CAN bus as one participant sees it. Frames it sends are not received by itself. One thread may
/// receive while another sends.
class CanBus {
 public:
  virtual ~CanBus() = default;
  /// The next frame or event; nothing after `timeout`.
  virtual std::optional<CanInput> receive(std::chrono::nanoseconds timeout) = 0;
  /// "" when the frame was handed on, else why not: one line. Never waits longer than some
  /// milliseconds.
  virtual std::string send(const CanFrame& frame) = 0;
  virtual const std::string& name() const = 0;
};

/// Opens "slcan:/dev/ttyACM0" (a serial adapter that speaks Lawicel's protocol, `bit_rate` is set
/// in it) or the network interface of that name, "can0", "vcan0" (its bit rate is set by the
/// system; `bit_rate` is compared with it, 0 compares nothing). Only frames with one of
/// `identifiers` are received; empty: all.
/// @throws geometry::InputError naming interface and mend: no CAN in this kernel, no such
/// interface, interface down, another bit rate; or as open_byte_stream.
std::unique_ptr<CanBus> open_can_bus(const std::string& name, unsigned bit_rate,
                                     const std::vector<std::uint16_t>& identifiers);

}  // namespace prehend::drivers
