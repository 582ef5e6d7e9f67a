#pragma once

#include <chrono>
#include <cstdint>
#include <set>

#include "drivers/pg70/transport/link.h"
#include "drivers/wire/probe/probe.h"

namespace prehend::drivers::pg70 {

/// Asks the module of `address` for its state. It first listens for 0.15 s: a module that somebody
/// uses sends states by itself, and is not asked. Else GET STATE is sent, at most three times,
/// `patience` apart, the only message this ever sends: it moves nothing. Costs up to
/// 0.15 s + 3 * patience when nobody answers; then it says what was heard instead.
/// @throws geometry::InputError as open_link when there is no such line.
Probe probe(const LinkAddress& address,
            std::chrono::nanoseconds patience = std::chrono::milliseconds(300));

/// Who else uses a line.
struct OtherTraffic {
  std::set<std::uint8_t> modules;  // that talk by themselves: somebody has asked them to
  std::uint64_t others = 0;        // CAN frames of no module, or bytes
  bool any() const { return !modules.empty() || others > 0; }
};

/// Listens for a second, and sends nothing.
/// @throws geometry::InputError as open_link.
OtherTraffic listen(const LinkAddress& address);

/// Sends GET STATE to all ids that are not heard anyway, and returns those that answer; takes some
/// 1 s on CAN, 4 s on RS-232 at 9600 baud. `address.module` is not used.
/// @throws geometry::InputError as open_link.
std::set<std::uint8_t> find_modules(const LinkAddress& address);

}  // namespace prehend::drivers::pg70
