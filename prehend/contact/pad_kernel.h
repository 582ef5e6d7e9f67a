#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/contact/pad_layout.h"
#include "prehend/contact/pad_state.h"
#include "prehend/contact/texel_law.h"

/// The law of texel.h for all texels of a pad at once, as vector code chosen at run time for the
/// processor (Highway). No function here
/// allocates, but explicit_step for foam that remembers. On one processor the same input gives
/// bitwise the same output; processors with other vector lengths differ by rounding.
namespace prehend::contact {

using Vector6 = Eigen::Matrix<double, 6, 1>;  // (velocity, angular velocity) or (force, torque)
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The pad's wrench on the touched body, about P's origin in P, as an affine function of the body's
/// twist relative to P at the step's end: constant - resistance * twist. resistance is symmetric
/// and positive semi-definite.
struct PadResponse {
  Vector6 constant = Vector6::Zero();
  Matrix6 resistance = Matrix6::Zero();
  int pressing = 0;  // texels
};

/// What respond() found for each texel and advance() uses; sized once, contents without meaning
/// between steps.
struct PadScratch {
  explicit PadScratch(const PadLayout& pad)
      : normal_offset(pad.padded_size(), 0.0),
        normal_damping(normal_offset),
        bristle_gain(normal_offset),
        tangential_damping(normal_offset),
        inverse_decay(normal_offset) {}
  std::vector<double> normal_offset, normal_damping, bristle_gain, tangential_damping,
      inverse_decay;
};

/// Linearises all texels over a step of `h` [s] at `twist_guess`, the touched body's twist relative
/// to the pad (m/s of the point at P's origin, rad/s; in P). Reads depth, bristles and foam of
/// `state`. The point of contact is on the texel's ray, `depth` behind the undeformed face.
/// @throws std::invalid_argument when the law remembers and `state` was made for another.
void respond(const PadLayout& pad, const TexelLaw& law, double h, const Vector6& twist_guess,
             const PadState& state, PadScratch& scratch, PadResponse& response);

/// Ends the step with the solved twist and the linearisation of the last respond(): fills forces,
/// bristles and foam. The sum of the texels' wrenches is that of the response at `twist`.
void advance(const PadLayout& pad, const TexelLaw& law, double h, const Vector6& twist,
             PadState& state, PadScratch& scratch);

/// Neither forces nor bristles: nothing touches.
void release(PadState& state);
/// Ends a step of `h` [s] in which nothing was near: the same, and foam that remembers comes back
/// further.
void release(const PadLayout& pad, const TexelLaw& law, double h, PadState& state);

/// The paper's explicit step: forces at the present state, into `state`, their wrench about P's
/// origin on the touched body; then bristles moved by h times their rate. Foam that remembers first
/// follows to the present depth. The oracle.
Vector6 explicit_step(const PadLayout& pad, const TexelLaw& law, double h, const Vector6& twist,
                      PadState& state);

/// Name of the vector target in use, e.g. "AVX2"; for reports.
std::string vector_target();

}  // namespace prehend::contact
