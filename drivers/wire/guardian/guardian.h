#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "drivers/wire/time/time.h"

namespace prehend::drivers {

/// What a device may do when nobody looks after it any more.
enum class Watch : char {
  kOff = 'o',       // nothing that a message could reach: no line
  kStanding = 's',  // it stands or holds
  kMoving = 'm',    // it moves, or may
};

/// The guardian of a device: a program that calls guard().
struct GuardianProgram {
  std::string name;                    // e.g. pg70_guardian, beside this program
  std::vector<std::string> arguments;  // where the device is; the patience [s] goes after them
  std::string device;                  // in words, e.g. "gripper"
};

/// A process of its own that stops a device when this process ends without saying so (killed,
/// crashed, out of memory), or lives but makes no progress (stopped, deadlocked). It is for devices
/// that have no watchdog themselves and would go on moving. The guardian waits at a socket; when
/// that closes, or nothing comes on it for `patience` (five times that while the device stands), it
/// opens the wire and stops the device (guard.h). It costs some wake-ups a second.
///
/// The guardian is watched in turn: each message of progress is answered, and one that died or does
/// not answer is replaced. For one thread.
class Guardian {
 public:
  static constexpr double kPatience = 0.3;  // s
  /// Starts the program.
  /// @throws std::runtime_error when it cannot be started.
  explicit Guardian(GuardianProgram program, double patience = kPatience);
  /// Tells it that all is well: it ends without touching the device.
  ~Guardian();
  Guardian(const Guardian&) = delete;
  Guardian& operator=(const Guardian&) = delete;

  /// What became of the guardian since the last call.
  struct News {
    bool stopped_device = false;  // this process made no progress; the wire was used by another
    std::string problem;          // one line; "" when all is well
  };
  /// Tells that the driver serves the device. Call it at least every patience / 4; it costs a
  /// system call each 20 ms.
  News progress(Watch watch);
  pid_t process() const { return process_; }

 private:
  void start();
  void end(bool kill);
  void replace(const std::string& words, News& news);

  GuardianProgram program_;
  double patience_;
  int socket_ = -1;
  pid_t process_ = -1;
  Time last_sent_ = Time::min(), last_start_ = Time::min();
  Watch last_watch_ = Watch::kOff;
  int unanswered_ = 0;  // messages in a row
  bool acts_ = false;   // it said that it stops the device
};

}  // namespace prehend::drivers
