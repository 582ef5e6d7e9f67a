#include "drivers/kuka_rsi/emulator/arm_plant.h"

#include <cmath>
#include <utility>

namespace prehend::drivers::kuka_rsi {

void SimpleArm::command(const Axes& q) {
  waiting_.push_back(q);
  is_commanded_ = true;
}

Axes SimpleArm::advance(double seconds) {
  if (!std::exchange(is_commanded_, false)) waiting_.push_back(waiting_.back());
  const double share = 1 - std::exp(-seconds / kLag);
  const Axes target = waiting_.front();
  if (waiting_.size() > kDeadCycles) waiting_.pop_front();
  for (std::size_t i = 0; i < kAxes; ++i) actual_[i] += share * (target[i] - actual_[i]);
  return actual_;
}

}  // namespace prehend::drivers::kuka_rsi
