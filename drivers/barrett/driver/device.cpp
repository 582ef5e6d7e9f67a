#include "drivers/barrett/driver/device.h"

#include <utility>
#include <vector>

namespace prehend::drivers::barrett {

std::unique_ptr<CanBus> open_hand_bus(const std::string& name, unsigned bit_rate) {
  std::vector<std::uint16_t> identifiers;
  for (std::size_t i = 0; i < kAxes; ++i) {
    for (const Group group : {Group::kReply, Group::kPosition, Group::kTactileAll}) {
      identifiers.push_back(reply_identifier(i, group));
    }
  }
  return open_can_bus(name, bit_rate, identifiers);
}

Device::Device(const DriverOptions& options, Open open, OnState on_state, Note note, double retry,
               OnRound on_round, Driver::OnPad on_pad)
    : WiredHand({.open = std::move(open),
                 .on_state = std::move(on_state),
                 .note = note,
                 .retry = retry,
                 .on_round = std::move(on_round)},
                [&](Now port) {
                  // What cannot be sent is lost; its answer is missed.
                  return std::make_unique<Driver>(
                      options,
                      [port](const CanFrame& frame) -> std::string {
                        return port() ? port()->send(frame) : "there is no bus to the hand";
                      },
                      note, std::move(on_pad));
                }) {}

}  // namespace prehend::drivers::barrett
