#pragma once

#include <array>
#include <cstdint>

#include "prehend/motion/batch_scene.h"

namespace prehend::motion {

/// Which of kBatch positions touch: bit i for lane i. Forward kinematics and tests of balls for all
/// lanes in step, with the machine's best vector instructions (after W. Thomason, Z. Kingston, L.
/// E. Kavraki, "Motions in microseconds via vectorized sampling-based planning", ICRA 2024). Limits
/// of joints are not looked at.
/// @param q positions [rad or m], lanes of one joint together: joints x kBatch, |q| < 1000.
/// @param stop_at_first end as soon as one lane touches: other bits may be missing then.
std::uint32_t touching_lanes(const BatchScene& scene, const float* q, bool stop_at_first);

/// What a chain may do on a short straight piece in joint space, from its middle to either end.
struct SweepBounds {
  static constexpr std::size_t kMost = 16;  // joints
  /// Way of each joint [rad or m].
  std::array<float, kMost> way{};
  /// How far a ball of joint k - 1 (0: of the base), seen from the frame of joint i - 1 (0: the
  /// base), may be from where it were if it went on with the speed of the middle [m], at
  /// [i * (kMost + 1) + k], i <= k; less what need not be looked at, so that it may be negative.
  std::array<float, (kMost + 1) * (kMost + 1)> bow{};
  /// The same of all balls, seen from the base, less what need not be looked at towards obstacles.
  std::array<float, kMost + 1> bow_in_world{};
};

/// Lanes that touch in the middle of their piece, and those that may touch somewhere on it.
struct SweptLanes {
  std::uint32_t touch = 0, may_touch = 0;
};

/// The same of straight pieces about kBatch positions, all as long in the same direction. Each ball
/// is larger by its own speed in each position and its bow. Ends as soon as a lane touches; others
/// may be missing then.
SweptLanes swept_lanes(const BatchScene& scene, const float* q, const SweepBounds& bounds);

}  // namespace prehend::motion
