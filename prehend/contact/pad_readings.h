#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/contact/pad_layout.h"
#include "prehend/contact/pad_state.h"
#include "prehend/contact/texel_law.h"

/// What a pad's forces mean; from the state after a step.
namespace prehend::contact {

double total_normal_force(const PadLayout& pad, const PadState& state);  // N

/// Normal force over area of each texel [Pa], size() values; 0 of what is no texel.
std::vector<double> pressure(const PadLayout& pad, const PadState& state);

/// Mean of the texels' positions weighted by normal force, in P [m]; the pad's origin when nothing
/// presses.
Eigen::Vector3d centre_of_pressure(const PadLayout& pad, const PadState& state);

/// Largest torque about the contact normal through the centre of pressure that friction can hold
/// [N m]: sum of mu Fn r with r the distance from that axis. `friction` is mu. The normal is the
/// force-weighted mean of the texels'.
double holding_torque(const PadLayout& pad, const PadState& state, double friction);

/// The integral of the same for a rectangle of sides a and b [m] under uniform pressure that sums
/// to `force` [N]: mu F / 6 [D + a^2/(2b) ln((b+D)/a) + b^2/(2a) ln((a+D)/b)], D^2 = a^2 + b^2.
double rectangle_holding_torque(double friction, double force, double a, double b);

enum class SlipState : unsigned char { kFree, kSticks, kSlips };

/// Each texel: free without normal force; slips when its bristle bears at least `share` of the
/// friction limit mu_d Fn. size() values.
std::vector<SlipState> slip_states(const PadLayout& pad, const TexelLaw& law, const PadState& state,
                                   double share = 0.98);

}  // namespace prehend::contact
