#pragma once

#include <vector>

#include "prehend/contact/pad_layout.h"

namespace prehend::contact {

/// What changes of a pad in a step; structure of arrays beside a PadLayout, all of its
/// padded_size(). Copy it to save it. Forces are of the whole texel (scaled by its area).
struct PadState {
  explicit PadState(const PadLayout& pad)
      : depth(pad.padded_size(), kFar),
        bristle_u(pad.padded_size(), 0.0),
        bristle_v(bristle_u),
        normal_force(bristle_u),
        friction_u(bristle_u),
        friction_v(bristle_u) {}

  static constexpr double kFar = -1e6;  // m, a depth that says: nothing within reach

  std::vector<double> depth;                 // m; negative: the gap to what the ray meets
  std::vector<double> bristle_u, bristle_v;  // m, along the texel's tangents
  // Of the last step.
  std::vector<double> normal_force;  // N, pushes the touched body out along the normal
  std::vector<double> friction_u,
      friction_v;  // N, on the pad: on the touched body it is minus this
};

}  // namespace prehend::contact
