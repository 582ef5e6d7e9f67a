#pragma once

#include <sys/types.h>

#include <string>

#include "drivers/pg70/transport/link.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::pg70 {

/// What the gripper may do when nobody looks after it any more.
enum class Watch : char {
  kOff = 'o',       // nothing that a message could reach: no link
  kStanding = 's',  // it stands or holds
  kMoving = 'm',    // it moves, or may
};

/// A process of its own that stops the gripper when this process ends without saying so (killed,
/// crashed, out of memory), or lives but makes no progress (stopped, deadlocked). The module itself
/// has no watchdog: it would go on moving. The guardian waits at a socket; when that closes, or
/// nothing comes on it for `patience` (five times that while the gripper stands), it opens the wire
/// and sends CMD STOP until it is answered, CMD FAST STOP too when it is not. It costs some
/// wake-ups a second.
///
/// The guardian is watched in turn: each message of progress is answered, and one that died or does
/// not answer is replaced. For one thread.
class Guardian {
 public:
  static constexpr double kPatience = 0.3;  // s
  /// Starts the program pg70_guardian beside this program.
  /// @throws std::runtime_error when it cannot be started.
  explicit Guardian(const LinkAddress& address, double patience = kPatience);
  /// Tells it that all is well: it ends without touching the gripper.
  ~Guardian();
  Guardian(const Guardian&) = delete;
  Guardian& operator=(const Guardian&) = delete;

  /// What became of the guardian since the last call.
  struct News {
    bool stopped_gripper = false;  // this process made no progress; the wire was used by another
    std::string problem;           // one line; "" when all is well
  };
  /// Tells that the driver serves the gripper. Call it at least every patience / 4; it costs a
  /// system call each 20 ms.
  News progress(Watch watch);
  pid_t process() const { return process_; }

 private:
  void start();
  void end(bool kill);
  void replace(const std::string& words, News& news);

  LinkAddress address_;
  double patience_;
  int socket_ = -1;
  pid_t process_ = -1;
  Time last_sent_ = Time::min(), last_start_ = Time::min();
  Watch last_watch_ = Watch::kOff;
  int unanswered_ = 0;  // messages in a row
  bool acts_ = false;   // it said that it stops the gripper
};

/// What the guardian's process does on its end of the socket; see Guardian. `patience` [s] without
/// progress while the gripper moves; `stop_time` [s] for a dead driver's gripper to answer a stop.
/// Returns an exit code: 0, or 1 when no stop was answered in that time.
int guard(int socket, const LinkAddress& address, double patience = Guardian::kPatience,
          double stop_time = 5);

}  // namespace prehend::drivers::pg70
