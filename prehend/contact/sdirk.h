#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/contact/pad_state.h"

/// SDIRK2 (Alexander, "Diagonally Implicit Runge-Kutta Methods for Stiff O.D.E.'s", 1977), L-stable
/// and stiffly accurate, as two backward Euler steps of kSdirkGamma times the step each: the second
/// begins at y0 + (1 - gamma) / gamma (y1 - y0).
namespace prehend::contact {

inline constexpr double kSdirkGamma = 0.29289321881345247560;  // 1 - 1/sqrt(2)
inline constexpr double kSdirkExtrapolation = (1 - kSdirkGamma) / kSdirkGamma;

/// Where the second step begins, of any quantity that adds up.
template <class Value>
Value sdirk_extrapolated(const Value& base, const Value& first) {
  return base + kSdirkExtrapolation * (first - base);
}

/// Of a rigid body. Frame B has the centre of mass as origin.
struct RigidMotion {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();  // m
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          // m/s
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // rad/s, world
};
/// Rotations by the rotation vector; of the turning motion the angular momentum adds up. `inertia`
/// is in B [kg m^2].
RigidMotion sdirk_extrapolated(const RigidMotion& base, const RigidMotion& first,
                               const Eigen::Matrix3d& inertia);

/// The bristles of a pad's texels, into `out`; none where `first` ceased to touch. And its foam.
void sdirk_extrapolate(const PadState& base, const PadState& first, PadState& out);
/// Of foam nothing is extrapolated: it follows the depths exactly, by way of the first stage's,
/// over the time from there to the step's end.
void sdirk_keep_foam(const PadState& first, PadState& out);

}  // namespace prehend::contact
