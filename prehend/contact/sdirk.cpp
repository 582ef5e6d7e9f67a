#include "prehend/contact/sdirk.h"

#include "prehend/contact/rotation.h"

namespace prehend::contact {

RigidMotion sdirk_extrapolated(const RigidMotion& base, const RigidMotion& first,
                               const Eigen::Matrix3d& inertia) {
  RigidMotion out;
  out.p_WB = sdirk_extrapolated(base.p_WB, first.p_WB);
  const Eigen::Vector3d turn = rotation_vector(first.q_WB * base.q_WB.conjugate());
  out.q_WB = (rotation_by(kSdirkExtrapolation * turn) * base.q_WB).normalized();
  out.velocity = sdirk_extrapolated(base.velocity, first.velocity);
  if (turn.isZero(0) && first.angular_velocity.isZero(0) && base.angular_velocity.isZero(0)) {
    return out;
  }
  const auto momentum = [&](const RigidMotion& s) {
    return Eigen::Vector3d(s.q_WB * (inertia * (s.q_WB.conjugate() * s.angular_velocity)));
  };
  const Eigen::Vector3d L = sdirk_extrapolated(momentum(base), momentum(first));
  out.angular_velocity = out.q_WB * (inertia.inverse() * (out.q_WB.conjugate() * L));
  return out;
}

void sdirk_extrapolate(const PadState& base, const PadState& first, PadState& out) {
  for (std::size_t i = 0; i < first.normal_force.size(); ++i) {
    const bool touches = first.normal_force[i] > 0;
    out.bristle_u[i] = touches ? sdirk_extrapolated(base.bristle_u[i], first.bristle_u[i]) : 0.0;
    out.bristle_v[i] = touches ? sdirk_extrapolated(base.bristle_v[i], first.bristle_v[i]) : 0.0;
  }
  sdirk_keep_foam(first, out);
}

void sdirk_keep_foam(const PadState& first, PadState& out) {
  out.foam = first.foam;
  out.foam_due = kSdirkExtrapolation;
}

}  // namespace prehend::contact
