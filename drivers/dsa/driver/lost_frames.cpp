#include "drivers/dsa/driver/lost_frames.h"

#include <algorithm>

namespace prehend::drivers::dsa {

void LostFrames::take(std::uint32_t timestamp, std::uint64_t damaged) {
  const std::uint32_t length = timestamp - last_timestamp_;
  last_timestamp_ = timestamp;
  if (!has_last_) {
    has_last_ = true;
    return;
  }
  last_ = {last_[1], last_[2], Interval{length, damaged}};
  intervals_ = std::min(intervals_ + 1, 3);
  if (intervals_ < 3) return;
  // A stamp counts milliseconds: an interval is known to within one.
  const std::uint64_t usual = std::max<std::uint64_t>({last_[0].length, last_[2].length, 1});
  const std::uint64_t between = last_[1].length;
  if (2 * between < 3 * usual + 2) return;
  const std::uint64_t missing = (between + usual / 2) / usual - 1;
  count_ += missing - std::min(missing, last_[1].damaged);
}

}  // namespace prehend::drivers::dsa
