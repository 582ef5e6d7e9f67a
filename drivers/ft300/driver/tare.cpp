#include "drivers/ft300/driver/tare.h"

namespace prehend::drivers::ft300 {

void Tare::begin(int count) {
  wanted_ = count;
  count_ = 0;
  sum_ = {};
}

bool Tare::add(const Measurement& measurement) {
  if (wanted_ == 0) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    sum_.force[i] += measurement.force[i];
    sum_.torque[i] += measurement.torque[i];
  }
  if (++count_ < wanted_) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    offset_.force[i] = sum_.force[i] / count_;
    offset_.torque[i] = sum_.torque[i] / count_;
  }
  wanted_ = 0;
  is_set_ = true;
  return true;
}

Measurement Tare::apply(const Measurement& measurement) const {
  Measurement result = measurement;
  for (std::size_t i = 0; i < 3; ++i) {
    result.force[i] -= offset_.force[i];
    result.torque[i] -= offset_.torque[i];
  }
  return result;
}

}  // namespace prehend::drivers::ft300
