#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "drivers/pg70/codec/message.h"
#include "drivers/wire/can/can_bus.h"
#include "drivers/wire/stream/byte_stream.h"

namespace prehend::drivers::pg70 {

/// Which end of the wire this is.
enum class Side { kMaster, kModule };

/// A whole message of the other side.
struct Incoming {
  Direction direction = Direction::kResponse;
  Content content;
};

/// What happened to the way messages take.
struct LinkEvent {
  enum class Kind {
    kDisturbed,  ///< messages may have been lost
    kDown,       ///< nothing passes now (bus-off, interface down); may come back by itself
    kUp,         ///< passes again
    kClosed,     ///< gone; open another link
    kLeft,       ///< given up by this side; open another link
  };
  Kind kind = Kind::kDisturbed;
  std::string words;
};

using LinkInput = std::variant<Incoming, LinkEvent>;

/// Whole SMP messages to and from one module. One thread may receive while another sends.
class Link {
 public:
  virtual ~Link() = default;
  virtual std::optional<LinkInput> receive(std::chrono::nanoseconds timeout) = 0;
  /// "" when handed on, else why not. `direction`: of a module's messages; a master's are commands.
  virtual std::string send(Direction direction, const Content& content) = 0;
  virtual const std::string& name() const = 0;
  /// Messages that were given up, and stretches of bytes that were none.
  virtual std::uint64_t damaged() const = 0;
};

/// Over CAN, fragmented where needed.
std::unique_ptr<Link> make_can_link(std::unique_ptr<CanBus> bus, std::uint8_t module, Side side);

/// Over a serial line (or TCP to a serial server), with checksums. A message that stalls for
/// `gap` is given up.
std::unique_ptr<Link> make_serial_link(
    std::unique_ptr<ByteStream> stream, std::uint8_t module, Side side,
    std::chrono::nanoseconds gap = std::chrono::milliseconds(50));

/// bit/s of RS-232 unless set otherwise in the module (spatialaudio/schunk).
inline constexpr unsigned kFactoryBaud = 9600;

/// Where a module is.
struct LinkAddress {
  std::string line;       // "can0", "slcan:/dev/ttyACM0", "serial:/dev/ttyUSB0", "serial:tcp://..."
  unsigned bit_rate = 0;  // CAN: to compare with or (slcan) to set, 0: as it is; serial: baud
  std::uint8_t module = 12;  // 1..255
};

/// Opens the master's end. @throws geometry::InputError as open_can_bus and open_byte_stream.
std::unique_ptr<Link> open_link(const LinkAddress& address);

}  // namespace prehend::drivers::pg70
