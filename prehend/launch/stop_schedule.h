#pragma once

#include <chrono>
#include <optional>

namespace prehend::launch {

/// How long a process that was asked to stop (SIGINT) is left alone.
struct StopTimes {
  std::chrono::milliseconds patience;   ///< from SIGINT to SIGTERM
  std::chrono::milliseconds terminate;  ///< from SIGTERM to SIGKILL, and from that to giving up
  std::chrono::milliseconds hurried;    ///< from SIGINT to SIGKILL, once there is a hurry
};

/// Which signal one process gets when, after the SIGINT that asked it to stop. Pure reckoning: the
/// caller sends.
class StopSchedule {
 public:
  using Time = std::chrono::steady_clock::time_point;
  struct Step {
    int signal;
    Time when;
  };

  /// `begun`: when SIGINT was sent.
  StopSchedule(const StopTimes& times, Time begun) : times_(times), begun_(begun), sent_(begun) {}

  /// Somebody cannot wait: SIGKILL comes `hurried` after SIGINT, and no SIGTERM any more.
  void hurry() { hurried_ = true; }
  /// What comes next; empty once SIGKILL was sent.
  std::optional<Step> next() const;
  /// The signal to send now, if one is due: then it counts as sent.
  std::optional<int> take_due(Time now);
  /// SIGKILL was sent long ago, and the process is there still (the kernel keeps it).
  bool is_hopeless(Time now) const;

 private:
  const StopTimes times_;
  const Time begun_;
  Time sent_;  // when the last signal was
  int last_ = 0;
  bool hurried_ = false;
};

}  // namespace prehend::launch
