#pragma once

#include <vector>

#include "prehend/contact/pad_layout.h"
#include "prehend/contact/texel_law.h"

namespace prehend::contact {

/// What changes of a pad in a step; structure of arrays beside a PadLayout, all of its
/// padded_size(). Copy it to save it. Forces are of the whole texel (scaled by its area).
struct PadState {
  /// `law` says what the texels' foam remembers.
  explicit PadState(const PadLayout& pad, const TexelLaw& law = {})
      : depth(pad.padded_size(), kFar),
        bristle_u(pad.padded_size(), 0.0),
        bristle_v(bristle_u),
        normal_force(bristle_u),
        friction_u(bristle_u),
        friction_v(bristle_u),
        foam(law.memory.terms() > 0 ? (1 + law.memory.terms()) * pad.padded_size() : 0, 0.0) {}

  static constexpr double kFar = -1e6;  // m, a depth that says: nothing within reach

  std::vector<double> depth;                 // m; negative: the gap to what the ray meets
  std::vector<double> bristle_u, bristle_v;  // m, along the texel's tangents
  // Of the last step.
  std::vector<double> normal_force;  // N, pushes the touched body out along the normal
  std::vector<double> friction_u,
      friction_v;  // N, on the pad: on the touched body it is minus this
  /// Of a foam that remembers, else empty: each texel's compression [m], then of each term, first
  /// creep's, its spring's stretch [m] in each texel. See foam.h.
  std::vector<double> foam;
  /// Time that the foam has not seen yet at the end of the next step, in steps: 1 but between the
  /// stages of second-order steps, see sdirk_extrapolate.
  double foam_due = 1;
};

}  // namespace prehend::contact
