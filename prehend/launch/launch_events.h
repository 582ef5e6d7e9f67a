#pragma once

#include <vector>

#include "prehend/launch/supervised_process.h"

// What a launch waits for.
namespace prehend::launch {

/// SIGINT, SIGTERM, SIGHUP and SIGCHLD as something to poll. Blocks them in the calling thread, and
/// in those it makes later.
class SignalSource {
 public:
  SignalSource();
  ~SignalSource();
  SignalSource(const SignalSource&) = delete;
  SignalSource& operator=(const SignalSource&) = delete;

  int file() const { return file_; }
  /// The next signal that asks to stop, 0 when there is none.
  int take_stop() const;

 private:
  int file_ = -1;
};

/// Returns when a signal came, a process wrote or ended, or at `deadline`.
void wait_for_events(const SignalSource& signals, const std::vector<SupervisedProcess*>& processes,
                     SupervisedProcess::Clock::time_point deadline);

}  // namespace prehend::launch
