#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace prehend::drivers {

/// What an emulated hand moves: the mechanics behind its electronics. SI units, axes in the order
/// of the device's.
template <std::size_t kCount>
class HandPlant {
 public:
  using Values = std::array<double, kCount>;
  /// What an axis' controller asks for from now on.
  struct Drive {
    bool powered = false;       // off: the gear alone holds it, or nothing
    double position = 0;        // rad, where its profile is
    double speed = 0;           // rad/s, most
    double current = 0;         // most: A, or the device's own unit
    bool self_locking = false;  // off it keeps what it presses with, as worm gears do
  };
  struct Motion {
    Values position{};  // rad, of the motors, at their joints
    Values joint{};     // rad, of the joints: another one where contact has opened a clutch
    Values velocity{};  // rad/s
    Values current{};   // A, or the device's own unit
    double time = 0;    // s of the plant's own clock, which may run slower than the hand's
  };

  virtual ~HandPlant() = default;
  virtual void command(const std::array<Drive, kCount>& drives) = 0;
  /// Moves on by so many seconds and tells where it is.
  virtual Motion advance(double seconds) = 0;
};

/// Axes that follow their drives as far as nothing is in their way.
template <std::size_t kCount>
class SimpleHand : public HandPlant<kCount> {
 public:
  using Drive = typename HandPlant<kCount>::Drive;
  using Motion = typename HandPlant<kCount>::Motion;
  SimpleHand() { least_.fill(-10), most_.fill(10); }
  /// The axis gets no farther than this [rad] once it is below.
  void put_object(std::size_t axis, double position) { most_.at(axis) = position; }
  void remove_object() { most_.fill(10); }
  void set_stuck(bool stuck) { is_stuck_ = stuck; }

  void command(const std::array<Drive, kCount>& drives) override { drives_ = drives; }
  Motion advance(double seconds) override {
    constexpr double kFree = 0.05;  // A, that an axis takes to move with nothing in its way
    if (seconds <= 0) return motion_;
    motion_.time += seconds;
    for (std::size_t i = 0; i < kCount; ++i) {
      const Drive& drive = drives_[i];
      const double before = motion_.position[i];
      motion_.velocity[i] = motion_.current[i] = 0;
      if (!drive.powered) continue;
      const double way = drive.position - before;
      const double step = std::clamp(way, -drive.speed * seconds, drive.speed * seconds);
      const double wanted = before + (is_stuck_ || drive.current <= 0 ? 0.0 : step);
      motion_.position[i] =
          std::clamp(wanted, least_[i], std::max(most_[i], std::min(before, wanted)));
      motion_.velocity[i] = (motion_.position[i] - before) / seconds;
      const bool is_blocked = std::abs(way) > 1e-4 && motion_.position[i] == before;
      const double most = is_blocked ? drive.current : std::min(drive.current, kFree);
      if (way != 0) motion_.current[i] = std::copysign(most, way);
    }
    motion_.joint = motion_.position;
    return motion_;
  }

 private:
  std::array<Drive, kCount> drives_{};
  std::array<double, kCount> least_{}, most_{};
  bool is_stuck_ = false;
  Motion motion_;
};

}  // namespace prehend::drivers
