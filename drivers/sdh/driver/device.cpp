#include "drivers/sdh/driver/device.h"

#include <utility>

namespace prehend::drivers::sdh {

Device::Device(const DriverOptions& options, Open open, OnState on_state, Note note, double retry,
               OnRound on_round)
    : WiredHand({.open = std::move(open),
                 .on_state = std::move(on_state),
                 .note = note,
                 .retry = retry,
                 .on_round = std::move(on_round),
                 .power_off_at_end = options.power_off_at_end},
                [&](Now port) {
                  // What cannot be written is lost; its answer is missed.
                  return std::make_unique<Driver>(
                      options,
                      [port](Bytes bytes) -> std::string {
                        return port() ? port()->send(bytes) : "there is no line to the hand";
                      },
                      note);
                }) {}

}  // namespace prehend::drivers::sdh
