#pragma once

#include <array>

#include "drivers/sdh/codec/codes.h"

namespace prehend::drivers::sdh {

/// What an emulated hand moves: the mechanics behind its electronics. SI units, axes as in codes.h.
class HandPlant {
 public:
  /// What an axis' controller asks for from now on.
  struct Drive {
    bool powered = false;  // off: the gear alone holds it
    double position = 0;   // rad, where its profile is
    double speed = 0;      // rad/s, most
    double current = 0;    // A, most
  };
  struct Motion {
    AxisValues position{};  // rad
    AxisValues velocity{};  // rad/s
    AxisValues current{};   // A
    double time = 0;        // s of the plant's own clock, which may run slower than the hand's
  };

  virtual ~HandPlant() = default;
  virtual void command(const std::array<Drive, kAxes>& drives) = 0;
  /// Moves on by so many seconds and tells where it is.
  virtual Motion advance(double seconds) = 0;
};

/// Axes that follow their drives as far as nothing is in their way.
class SimpleHand : public HandPlant {
 public:
  SimpleHand() { least_.fill(-10), most_.fill(10); }
  /// The axis gets no farther than this [rad] once it is below.
  void put_object(std::size_t axis, double position) { most_.at(axis) = position; }
  void remove_object() { most_.fill(10); }
  void set_stuck(bool stuck) { is_stuck_ = stuck; }

  void command(const std::array<Drive, kAxes>& drives) override { drives_ = drives; }
  Motion advance(double seconds) override;

 private:
  std::array<Drive, kAxes> drives_{};
  AxisValues least_{}, most_{};
  bool is_stuck_ = false;
  Motion motion_;
};

}  // namespace prehend::drivers::sdh
