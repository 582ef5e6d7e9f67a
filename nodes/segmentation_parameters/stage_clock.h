#pragma once

#include <chrono>

#include "msgs/objects.pb.h"

namespace prehend::nodes {

/// Measures the stages of one piece of work, one after the other.
class StageClock {
 public:
  /// Adds the seconds (wall time) since the last call, or since construction, to the message's
  /// times.
  void end_stage(msgs::ObjectHypotheses& message, const char* stage) {
    const auto now = std::chrono::steady_clock::now();
    msgs::StageTime* time = message.add_times();
    time->set_stage(stage);
    time->set_seconds(std::chrono::duration<double>(now - start_).count());
    start_ = now;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace prehend::nodes
