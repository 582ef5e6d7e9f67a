#pragma once

#include <array>
#include <cstddef>
#include <string>

namespace prehend::drivers {

/// What a driver keeps a hand's axes within, each with a motor of its own.
template <std::size_t kCount>
struct HandLimits {
  using Values = std::array<double, kCount>;
  Values lower{}, upper{};  // rad
  Values max_speed{};       // rad/s; less where the hand says so
  Values max_current{};     // A, or the device's own unit of what its motors may press with
};

/// Where axes are to go. Those that are not to move stay where they are held.
template <std::size_t kCount>
struct HandGoal {
  using Values = std::array<double, kCount>;
  std::array<bool, kCount> moves{};
  Values position{};  // rad
  Values speed{};     // rad/s, at most
  Values current{};   // as HandLimits::max_current, at most; 0: the greatest
};

/// Of a continuous command.
enum class CommandMode { kStop, kPosition, kVelocity };

/// A motion that was refused, or how far it is.
struct MotionReport {
  enum class Kind { kRunning, kReached, kBlocked, kReplaced, kFailed };
  Kind kind = Kind::kRunning;
  std::string reason;  // of kFailed
};

}  // namespace prehend::drivers
