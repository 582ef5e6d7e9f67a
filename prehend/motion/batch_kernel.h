#pragma once

#include <cstdint>

#include "prehend/motion/batch_scene.h"

namespace prehend::motion {

/// Which of kBatch positions touch: bit i for lane i. Forward kinematics and tests of balls for all
/// lanes in step, with the machine's best vector instructions (after W. Thomason, Z. Kingston, L.
/// E. Kavraki, "Motions in microseconds via vectorized sampling-based planning", ICRA 2024). Limits
/// of joints are not looked at.
/// @param q positions [rad or m], lanes of one joint together: joints x kBatch, |q| < 1000.
/// @param stop_at_first end as soon as one lane touches: other bits may be missing then.
/// @param swell by how much the balls of each joint are larger towards obstacles [m], >= 0; null:
/// not.
std::uint32_t touching_lanes(const BatchScene& scene, const float* q, bool stop_at_first,
                             const float* swell = nullptr);

}  // namespace prehend::motion
