#pragma once

#include <vector>

#include "prehend/contact/texel_law.h"

namespace prehend::contact {

/// One texel of reference area under a face that moves as prescribed, with the foam of foam.h: the
/// normal force of a whole pad step by step, without the pad.
class FoamTexel {
 public:
  /// @throws std::invalid_argument, see validate(TexelLaw).
  explicit FoamTexel(const TexelLaw& law);
  /// The face moves to `depth` [m] within `h` [s], > 0; negative: a gap. Returns the force then
  /// [N].
  double press(double h, double depth);

 private:
  TexelLaw law_;
  std::vector<double> foam_;
  double depth_ = 0;  // m
};

}  // namespace prehend::contact
