#pragma once

#include <algorithm>
#include <optional>

#include "drivers/wire/time/time.h"

namespace prehend::drivers::camera {

/// Brings stamps of a device's own clock to that of steady_now(): device time plus the least delay
/// that was seen from device time to arrival, as what arrives late says only that it was late. A
/// device's clock that jumps, or drifts off by kMostDelay, is begun anew with. For one thread.
class DeviceClock {
 public:
  static constexpr Time kMostDelay = std::chrono::milliseconds(500);
  /// A slow device's clock would be believed less and less: so much is taken back with each stamp.
  static constexpr Time kDrift = std::chrono::microseconds(2);

  /// Never later than `arrival`.
  Time to_host(Time device, Time arrival) {
    const Time offset = arrival - device;
    if (!offset_ || device < last_ || offset - *offset_ > kMostDelay) {
      offset_ = offset;
    } else {
      offset_ = std::min(offset, *offset_ + kDrift);
    }
    last_ = device;
    return device + *offset_;
  }

 private:
  std::optional<Time> offset_;
  Time last_{};
};

}  // namespace prehend::drivers::camera
