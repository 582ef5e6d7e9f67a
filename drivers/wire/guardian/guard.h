#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "drivers/wire/guardian/guardian.h"

namespace prehend::drivers {

/// What the guardian's process does for one kind of device.
struct Guarding {
  std::string program;  // its own name, before what it says
  std::string device;   // e.g. "gripper"
  std::string stop;     // what is sent first, e.g. "CMD STOP"
  /// Opens the wire anew and tries to stop the device until `end`, or until `is_back`: the driver
  /// spoke again, and the wire is its own. Returns what was answered, e.g. "CMD STOP"; "" when
  /// nothing was. May throw std::runtime_error: the wire cannot be opened; it is tried again.
  std::function<std::string(Time end, const std::function<bool()>& is_back)> stop_device;
};

/// What the guardian's process does on its end of the socket; see Guardian. `patience` [s] without
/// progress while the device moves; `stop_time` [s] for a dead driver's device to answer a stop.
/// Returns an exit code: 0, or 1 when no stop was answered in that time.
int guard(int socket, const Guarding& guarding, double patience = Guardian::kPatience,
          double stop_time = 5);
/// The same at the standard input, where Guardian puts the socket. SIGINT and SIGTERM, which end
/// the driver, are not minded.
int guard_standard_input(const Guarding& guarding, double patience);
/// The main function of a guardian whose arguments are `count` words and the patience; `make` makes
/// its Guarding of the words.
int guard_by_words(int argc, char** argv, std::size_t count,
                   const std::function<Guarding(const std::vector<std::string>& words)>& make);
/// Of such a word: a rate or an address.
unsigned number_of(const std::string& word);

}  // namespace prehend::drivers
