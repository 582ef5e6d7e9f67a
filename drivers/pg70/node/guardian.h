#pragma once

#include <sys/types.h>

#include "drivers/pg70/transport/link.h"

namespace prehend::drivers::pg70 {

/// A process of its own that stops the gripper when this process ends without saying so: killed,
/// crashed, out of memory. (The module itself has no watchdog: it would go on moving.) It waits at
/// a pipe that only this process holds open; when that closes, it opens the wire and sends CMD STOP
/// until it is answered. It uses no processor time before.
class Guardian {
 public:
  /// Starts the program pg70_guardian beside this program.
  /// @throws std::runtime_error when it cannot be started.
  explicit Guardian(const LinkAddress& address);
  /// Tells it that all is well: it ends without touching the gripper.
  ~Guardian();
  Guardian(const Guardian&) = delete;
  Guardian& operator=(const Guardian&) = delete;

 private:
  int pipe_ = -1;
  pid_t process_ = -1;
};

/// What the guardian's process does: reads `input` to its end; unless the end was announced, stops
/// the module. Returns an exit code: 0, or 1 when no stop was answered within `patience` seconds.
int guard(int input, const LinkAddress& address, double patience = 5);

}  // namespace prehend::drivers::pg70
