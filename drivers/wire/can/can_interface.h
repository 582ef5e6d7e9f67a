#pragma once

#include <optional>
#include <string>

namespace prehend::drivers {

/// What the system says of a CAN network interface.
struct CanInterface {
  std::string kind;  // "can", "vcan", "slcan" (a serial line attached by slcand), ...
  bool is_up = false;
  unsigned bit_rate = 0;  // bits/s, 0: the interface has none (vcan) or does not say
  std::string state;      // of the controller: "error-active", "bus-off", ...; "": not said
};

/// Asks the kernel by netlink; nothing when there is no interface of that name.
/// @throws std::runtime_error when the kernel cannot be asked.
std::optional<CanInterface> find_can_interface(const std::string& name);

/// True when the kernel offers CAN sockets (after loading modules, where that is allowed).
bool kernel_has_can();

}  // namespace prehend::drivers
