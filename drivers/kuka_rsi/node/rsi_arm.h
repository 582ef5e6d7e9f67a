#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <vector>

#include "drivers/kuka_rsi/driver/device.h"
#include "nodes/arm_action/arm_action.h"

namespace prehend::drivers::kuka_rsi {

/// The arm as /arm/follow moves it: trajectories are checked and interpolated to the controller's
/// cycle by who asks, and handed over as a whole.
class RsiArm : public nodes::MovedArm {
 public:
  /// `path_tolerance` [rad]: of goals that give none.
  RsiArm(Device& device, const Limits& limits, double cycle, double path_tolerance)
      : device_(device), limits_(limits), cycle_(cycle), path_tolerance_(path_tolerance) {}

  std::uint64_t take_arm() override { return ++ticket_; }
  bool holds_arm(std::uint64_t ticket) override { return ticket == ticket_; }
  void stop_arm(std::uint64_t ticket) override;
  void follow(const simulation::TrajectoryRequest& request, const std::vector<double>& tolerance,
              double contact_force) override;
  State arm_state() override;
  void wait_for_slice() override;

 private:
  std::string words_of(const Snapshot& now) const;

  Device& device_;
  const Limits& limits_;
  const double cycle_, path_tolerance_;
  std::atomic<std::uint64_t> ticket_ = 0;
  std::mutex mutex_;           // guards what follows
  std::uint64_t motions_ = 0;  // that were handed over
};

}  // namespace prehend::drivers::kuka_rsi
