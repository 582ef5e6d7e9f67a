#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace prehend::shape {

/// One plane as the vote's kernel wants it, in the coordinates (a, b, c) of FastVote.
struct KernelPlane {
  float motion_0, motion_a, motion_b, motion_c;  // motion = motion_0 + motion_abc · (a, b, c) [m]
  float normal_a, normal_b, normal_c;            // change of (a, b, c) per metre of motion
};

/// What the kernel sums for one plane; see VoteTally.
struct KernelSums {
  double outside_points = 0;
  double outside_pixels = 0;
  double nearer_points = 0;
  double nearer = 0;
  double outside_squared = 0;
  double in_front = 0;
  double coincident = 0;
  double contradicted = 0;
  double hidden = 0;
  double unseen = 0;
};

/// Floats that the kernel may read beyond the last point: the widest vector of any instruction set.
constexpr std::size_t kKernelPadding = 64;

struct KernelInput {
  const float* a;  // count and padding, and so b and c
  const float* b;
  const float* c;
  std::size_t count;
  float depth_center;  // m
  const float* map;    // SeenMap::values
  std::int32_t stride;
  float last_u, last_v;        // greatest coordinates within the map, with its ring
  float center_u, center_v;    // of a = b = 0 in the map, plus 1/2 for rounding
  float inverse_focal_length;  // 1/pixels
  float depth_tolerance;
  float least_motion;
};

/// Adds each plane's sums over all points to `sums`.
void sum_votes(const KernelInput& input, const std::vector<KernelPlane>& planes,
               std::vector<KernelSums>& sums);

}  // namespace prehend::shape
