#pragma once

#include "drivers/barrett/codec/axes.h"
#include "drivers/wire/hand/hand_plant.h"

namespace prehend::drivers::barrett {

using HandPlant = drivers::HandPlant<kAxes>;

/// A hand by itself: axes between their stops, things in the way of outer links (the motor stalls)
/// and of inner ones (the clutch opens, and the motor goes on).
class ClutchHand : public HandPlant {
 public:
  ClutchHand() { remove_objects(); }
  /// The motor gets no farther than this [rad] once it is below.
  void put_object(std::size_t axis, double position) { most_.at(axis) = position; }
  /// The inner joint gets no farther than this, and its motor no farther than `motor` [rad].
  void hold_joint(std::size_t axis, double joint, double motor) {
    joint_most_.at(axis) = joint;
    most_.at(axis) = motor;
  }
  void remove_objects() {
    constexpr double kFinger = 2.45, kSpreadEnd = 3.15;  // rad
    most_.fill(kFinger);
    most_[kSpread] = kSpreadEnd;
    joint_most_ = most_;
  }
  void set_stuck(bool stuck) { is_stuck_ = stuck; }
  /// Where it stands, e.g. at power-on.
  void place(std::size_t axis, double position) { motion_.position.at(axis) = position; }

  void command(const std::array<Drive, kAxes>& drives) override { drives_ = drives; }
  Motion advance(double seconds) override;

 private:
  std::array<Drive, kAxes> drives_{};
  AxisValues most_{}, joint_most_{};
  bool is_stuck_ = false;
  Motion motion_;
};

}  // namespace prehend::drivers::barrett
