#pragma once

#include "drivers/ft300/codec/measurement.h"

namespace prehend::drivers::ft300 {

/// The mean of so many measurements, as offset to subtract: the sensor has no zeroing command (the
/// vendor's driver subtracts on the host, too).
class Tare {
 public:
  /// Begins to collect `count` > 0 measurements.
  void begin(int count);
  /// Takes one in. True when it was the last of those collected.
  bool add(const Measurement& measurement);
  bool is_collecting() const { return wanted_ > 0; }
  bool is_set() const { return is_set_; }
  Measurement apply(const Measurement& measurement) const;

 private:
  int wanted_ = 0, count_ = 0;
  Measurement sum_, offset_;
  bool is_set_ = false;
};

}  // namespace prehend::drivers::ft300
