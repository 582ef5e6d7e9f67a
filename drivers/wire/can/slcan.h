#pragma once

#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/wire/can/can_bus.h"
#include "drivers/wire/stream/byte_stream.h"

namespace prehend::drivers {

/// "tiiildd...\r": a data frame as Lawicel's CANUSB protocol writes it (CANUSB manual V2.0D, page
/// 4), in upper-case hexadecimal.
std::string to_slcan(const CanFrame& frame);

/// A line without its \r; nothing when it is no standard data frame. A time stamp behind the data
/// (4 digits, command Z1) is skipped.
std::optional<CanFrame> from_slcan(std::string_view line);

/// The digit of command S for a bit rate; nothing when the protocol has none.
std::optional<char> slcan_rate(unsigned bit_rate);

/// A CAN bus behind a serial adapter that speaks this protocol, or the emulated device's end of
/// one.
class Slcan : public CanBus {
 public:
  /// Closes the adapter's channel, sets `bit_rate` (0: leaves it) and opens it.
  /// `identifiers` as open_can_bus. @throws geometry::InputError when the protocol has no such bit
  /// rate or the line does not take the commands.
  Slcan(std::unique_ptr<ByteStream> stream, unsigned bit_rate,
        std::vector<std::uint16_t> identifiers);
  /// Closes the channel.
  ~Slcan() override;

  std::optional<CanInput> receive(std::chrono::nanoseconds timeout) override;
  std::string send(const CanFrame& frame) override;
  const std::string& name() const override { return name_; }

 private:
  void take_lines();

  std::unique_ptr<ByteStream> stream_;
  std::vector<std::uint16_t> identifiers_;
  std::string name_;
  std::string partial_;
  std::deque<CanInput> inputs_;
};

}  // namespace prehend::drivers
