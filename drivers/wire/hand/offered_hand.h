#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/wire/hand/hand_motion.h"

namespace prehend::drivers {

/// A hand's driver with the device it drives, as HandOffers sees it. Any thread.
class OfferedHand {
 public:
  /// Of one axis.
  struct Target {
    std::size_t axis = 0;
    double position = 0;  // rad
    double speed = 0;     // rad/s, at most
    double current = 0;   // at most, A or the device's unit; 0: the greatest
  };
  virtual ~OfferedHand() = default;
  /// Why it was refused, or "".
  virtual std::string move_to(const std::vector<Target>& targets, std::uint64_t& ticket) = 0;
  virtual MotionReport report(std::uint64_t ticket) = 0;
  /// A continuous command: `values` in rad or rad/s, as many as axes. Why it was refused, or "".
  virtual std::string command(CommandMode mode, const std::vector<std::size_t>& axes,
                              const std::vector<double>& values) = 0;
  virtual void stop(const std::string& why) = 0;
  /// Switches the axes off, where that is something else than stopping.
  virtual void power_off(const std::string& why) = 0;
  virtual std::vector<double> positions() = 0;  // rad, of the axes
  /// Nothing moves or is on its way to, no stop is under way, and its answers show that.
  virtual bool is_settled() = 0;
  /// False: nothing can be sent.
  virtual bool is_connected() = 0;
  virtual std::string state() = 0;  // "standing", ...
};

}  // namespace prehend::drivers
