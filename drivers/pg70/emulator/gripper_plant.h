#pragma once

#include <optional>

namespace prehend::drivers::pg70 {

/// What an emulated module moves: the mechanics behind its wire. SI units; closing is negative.
class GripperPlant {
 public:
  enum class Drive {
    kOff,       // no current
    kHold,      // brakes and holds
    kPosition,  // to `value` [m]
    kVelocity,  // `value` [m/s]
    kCurrent,   // `value` [A]
  };
  struct Command {
    Drive drive = Drive::kHold;
    double value = 0;
    double speed = 0;         // m/s, most; kPosition
    double acceleration = 0;  // m/s^2, most
    double current = 0;       // A, most
  };
  struct Motion {
    double opening = 0;   // m
    double velocity = 0;  // m/s
    double current = 0;   // A
    double time = 0;      // s of the plant's own clock, which may run slower than the module's
  };

  virtual ~GripperPlant() = default;
  virtual void command(const Command& command) = 0;
  /// Moves on by so many seconds and tells where it is.
  virtual Motion advance(double seconds) = 0;
};

/// Two jaws on a trapezoidal speed profile between 0 and `max_opening`, with an optional thing
/// between them, and a finger that can be stuck.
class SimpleGripper : public GripperPlant {
 public:
  explicit SimpleGripper(double max_opening = 0.069, double opening = 0.069)
      : max_opening_(max_opening) {
    motion_.opening = opening;
  }
  /// The jaws do not close beyond this opening [m] (nothing: nothing is between them).
  void put_object(std::optional<double> width) { object_ = width; }
  void set_stuck(bool stuck) { stuck_ = stuck; }

  void command(const Command& command) override { command_ = command; }
  Motion advance(double seconds) override;

 private:
  double wanted_speed() const;

  double max_opening_;
  std::optional<double> object_;
  bool stuck_ = false;
  Command command_;
  Motion motion_;
};

}  // namespace prehend::drivers::pg70
