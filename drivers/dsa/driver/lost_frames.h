#pragma once

#include <array>
#include <cstdint>

namespace prehend::drivers::dsa {

/// Counts frames that the controller sent and that never came, from the time stamps of those that
/// did. The rate is not known beforehand (the firmware streams as fast as pads and line allow), so
/// an interval is compared with its two neighbours: as long as several of the longer one, it lacks
/// frames. Slower or faster frames from now on are none; where every second frame is lost, nothing
/// shows, and of neighbouring losses one.
class LostFrames {
 public:
  /// A good frame's time stamp [ms, the controller's clock, may wrap], and how many frames were
  /// damaged before it since the last good one: those came.
  void take(std::uint32_t timestamp, std::uint64_t damaged);
  /// The stream begins anew; the count goes on.
  void restart() {
    intervals_ = 0;
    has_last_ = false;
  }

  std::uint64_t count() const { return count_; }

 private:
  struct Interval {
    std::uint32_t length = 0;  // ms
    std::uint64_t damaged = 0;
  };
  std::array<Interval, 3> last_;  // the newest at the end
  int intervals_ = 0;             // of them that are valid
  bool has_last_ = false;
  std::uint32_t last_timestamp_ = 0;
  std::uint64_t count_ = 0;
};

}  // namespace prehend::drivers::dsa
