#pragma once

#include <array>
#include <deque>

#include "drivers/kuka_rsi/codec/telegram.h"

namespace prehend::drivers::kuka_rsi {

/// The arm behind an emulated controller: what its drives do with set points. Axes in rad.
class ArmPlant {
 public:
  virtual ~ArmPlant() = default;
  /// A set point, of this cycle.
  virtual void command(const Axes& q) = 0;
  /// A cycle later, `seconds`; returns where the axes are.
  virtual Axes advance(double seconds) = 0;
};

/// Drives alone: set points act `dead_cycles` later, and axes follow them with a lag of first
/// order. (How late a KR C is has not been published: two or three cycles and a lag are assumed.)
class SimpleArm : public ArmPlant {
 public:
  static constexpr int kDeadCycles = 2;
  static constexpr double kLag = 0.02;  // s

  explicit SimpleArm(const Axes& start) : actual_(start), waiting_(kDeadCycles, start) {}
  void command(const Axes& q) override;
  Axes advance(double seconds) override;
  const Axes& actual() const { return actual_; }

 private:
  Axes actual_;
  bool is_commanded_ = false;  // in this cycle
  std::deque<Axes> waiting_;   // set points that do not act yet, the oldest first
};

}  // namespace prehend::drivers::kuka_rsi
