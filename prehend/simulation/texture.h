#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace prehend::simulation {

/// A procedural colour of a body's points: solid noise with features of a few millimetres, so that
/// stereo matching finds something everywhere, over a pattern.
struct Texture {
  enum class Pattern {
    kNoise,    // blotches of both colours
    kStripes,  // horizontal bands of both colours
    kLabel,    // base colour with a band of the second in the middle half of the height
    kWood      // grain along x; for tables
  };
  Pattern pattern = Pattern::kNoise;
  Eigen::Vector3d color{0.75, 0.25, 0.2};        // red, green, blue in 0..1
  Eigen::Vector3d second_color{0.95, 0.9, 0.8};  // red, green, blue in 0..1
  double contrast = 0.35;                        // of the fine noise, 0..1
  double scale = 0.012;                          // m, size of the largest noise feature
  std::uint32_t seed = 1;
};

/// Colour (0..1) of the point `p_B` [m] of a body whose height reaches from z = 0 to `height` [m].
/// Pure: same arguments, same colour.
Eigen::Vector3d texture_color(const Texture& texture, const Eigen::Vector3d& p_B, double height);

}  // namespace prehend::simulation
