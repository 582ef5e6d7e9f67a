#pragma once

#include <optional>

#include "drivers/wire/time/time.h"

namespace prehend::drivers::camera {

/// Leaves out views, so that at most so many a second are handed on, by their stamps. For one
/// thread.
class DeliveryRate {
 public:
  /// @param most_rate 1/s, >= 0; 0: all are handed on.
  explicit DeliveryRate(double most_rate) : most_rate_(most_rate) {}

  /// Whether the view of `stamp` is handed on; one that is earlier than the last, of a file that
  /// begins anew, always is.
  bool lets_through(Time stamp) {
    constexpr double kSlack = 0.999;  // of the period: stamps are rounded
    if (most_rate_ > 0 && last_ && stamp >= *last_ &&
        stamp - *last_ < to_time(kSlack / most_rate_)) {
      return false;
    }
    last_ = stamp;
    return true;
  }

 private:
  double most_rate_;
  std::optional<Time> last_;
};

}  // namespace prehend::drivers::camera
