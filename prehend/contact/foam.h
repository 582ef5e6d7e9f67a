#pragma once

#include <cstddef>

#include "prehend/contact/pad_layout.h"
#include "prehend/contact/pad_state.h"
#include "prehend/contact/texel_law.h"

/// Creep and hysteresis of the texels' normal force, see FoamMemory. A texel's foam is compressed
/// by what presses on it, or comes back by itself as fast as its dashpots let it, without force; a
/// body touches it again where it has come to. Springs' stretches follow over a step in which the
/// compression changes evenly: exactly, for any step.
///   creep:      e+ = e exp(-h/T) + (T/h) (1 - exp(-h/T)) (d+ - d)
///   hysteresis: e+ = e + d+ - d, cut to the slider's depth
/// So the force at a step's end is a function of d+ alone that nowhere falls, of slope between the
/// law's and the law's with all springs: implicit steps stay symmetric and positive definite.
namespace prehend::contact {

/// k [N/m] that the shares of law.memory refer to: the law's stiffness, of kTabulated that of the
/// curve's last sample over its depth.
double memory_stiffness(const TexelLaw& law);

/// Fills offset and slope of each texel's normal force over the depth's rate at the end of a step
/// of `h` [s], from `rate` [m/s], the guessed ones: force = offset + slope * rate. The damper acts
/// where the foam presses at the step's start already. All of padded_size().
void linearise_foam(const PadLayout& pad, const TexelLaw& law, double h, const double* rate,
                    const PadState& state, double* offset, double* slope);

/// Ends a step of `h` [s] in which the depths changed at `rate` [m/s]: the foam's compression and
/// springs. Null: nothing was near.
void advance_foam(const PadLayout& pad, const TexelLaw& law, double h, const double* rate,
                  PadState& state);

/// What a step of `h` [s] is off by as a depth [m]: the largest difference in a texel's remembered
/// force, over the stiffness, between the stages' way to `next` and the straight one. Zero for foam
/// without memory.
double foam_step_error(const PadLayout& pad, const TexelLaw& law, double h, const PadState& start,
                       const PadState& next);
/// The largest difference of two states' remembered forces as a depth [m].
double foam_difference(const PadLayout& pad, const TexelLaw& law, const PadState& a,
                       const PadState& b);

/// Energy in the springs of texel `i` [J], of reference area.
double foam_energy(const PadLayout& pad, const TexelLaw& law, const PadState& state, std::size_t i);

}  // namespace prehend::contact
