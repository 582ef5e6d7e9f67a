#pragma once

#include <cstddef>

#include "prehend/motion/batch_scene.h"

namespace prehend::motion {

/// Index of the point with the least squared distance to `q`, the least index of several, in single
/// precision with the machine's best vector instructions.
/// @param blocks points in blocks of kBatch: joints x kBatch numbers each, the last filled up with
/// what is far. @param count of points, >= 1. @param q joints numbers.
std::size_t nearest_point(const float* blocks, std::size_t count, const float* q,
                          std::size_t joints);

}  // namespace prehend::motion
