#pragma once

#include <cstddef>
#include <functional>
#include <numbers>
#include <numeric>

namespace prehend::grasp {

/// Calls f(i) once for each 0 <= i < count on `threads` threads (0: as many as there are cores), in
/// any order. What f() throws first is thrown again, once all threads have ended.
void for_each_index(std::size_t count, int threads, const std::function<void(std::size_t)>& f);

/// A stride that has no divisor in common with `count`: i * stride % count for 0 <= i < count is
/// every index once, and the first of them are spread over all.
inline std::size_t spreading_stride(std::size_t count) {
  if (count <= 2) return 1;
  auto stride = static_cast<std::size_t>(static_cast<double>(count) / std::numbers::phi);
  while (std::gcd(stride, count) != 1) ++stride;
  return stride;
}

}  // namespace prehend::grasp
