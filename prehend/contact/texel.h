#pragma once

#include <Eigen/Core>

#include "prehend/contact/texel_law.h"

/// The soft contact law of texel_law.h as pure functions of one texel: the explicit form, which
/// serves as oracle, and the implicit step that a body solver folds into its system of equations.
/// pad_kernel.h does the same for whole pads, and there the foam remembers (TexelLaw::memory); here
/// it does not.
///
/// Signs: `depth` d > 0 is penetration [m], `depth_rate` its rate [m/s]; `velocity` v is the
/// tangential velocity of the touched body relative to the texel [m/s]; friction on the touched
/// body is -Ft. Everything tangential is a scalar times a vector, so the functions below hold for
/// 2-vectors in the texel's plane as well as for 3-vectors of that plane in space.
namespace prehend::contact {

/// Checks the constants of `law`. @throws std::invalid_argument naming the field: NaN or infinity
/// anywhere, a negative constant, a stiffness or Stribeck velocity that is not positive,
/// dynamic_friction above static_friction, exponent or elastic_limit out of range, a tabulated law
/// without its curve, creep or hysteresis of kHuntCrossley.
void validate(const TexelLaw& law);

/// True when the law cannot create energy: sigma2 > sigma1 (mu_s - mu_d) / mu_d, or mu_s == mu_d
/// (Olsson, "Control Systems with Friction", 1996, LuGre passivity).
bool is_passive(const TexelLaw& law);

/// The least sigma2 [N s/m] with which `law` is passive; zero without Stribeck effect.
/// @throws std::invalid_argument when dynamic_friction is zero and static_friction is not: no
/// viscous friction mends that.
double least_passive_viscous_friction(const TexelLaw& law);

/// The law's normal force and how it changes with depth and rate.
struct NormalResponse {
  double force = 0;      // N, not cut at zero
  double stiffness = 0;  // dFn/dd [N/m]
  double damping = 0;    // dFn/d(dd/dt) [N s/m]
};

/// A negative depth is a gap: its linear spring is continued, so that a step in which the gap
/// closes can be linearised; the other laws are zero there.
NormalResponse normal_response(const TexelLaw& law, double depth, double depth_rate);

/// Fn [N]; zero without penetration, never negative.
double normal_force(const TexelLaw& law, double depth, double depth_rate);

/// g = Fn [mu_d + (mu_s - mu_d) exp(-(v/v_s)^2)] [N], the friction of steady sliding at `speed`
/// without the viscous part.
double stribeck_force(const TexelLaw& law, double normal_force, double speed);

/// alpha of the elasto-plastic bristle for a bristle that bears `load` = sigma0 |z| / g and slides
/// further out (`outward`) or back: 0 elastic, 1 sliding, a cubic between elastic_limit and 1 (the
/// paper has half a sine, which differs by less than 1 %). 1 for kLuGre.
double plasticity(const TexelLaw& law, double load, bool outward);

/// Bristle rate dz/dt = v - alpha sigma0 |v| / g(v) z [m/s]. Zero normal force: the bristle has
/// nothing to hold, the rate is `velocity`.
Eigen::Vector2d bristle_rate(const TexelLaw& law, const Eigen::Vector2d& bristle,
                             const Eigen::Vector2d& velocity, double normal_force);

/// Ft = sigma0 z + sigma1 dz/dt + sigma2 v [N].
Eigen::Vector2d friction_force(const TexelLaw& law, const Eigen::Vector2d& bristle,
                               const Eigen::Vector2d& bristle_rate,
                               const Eigen::Vector2d& velocity);

/// The law over one step of length h as affine functions of the velocities at its end:
///   Fn+ = normal_offset + normal_damping dd/dt+          (linear law: k d, and h k + c)
///   Ft+ = bristle_gain z + tangential_damping v+
///   z+  = (z + h v+) / decay
/// so that a body with mass M and contact Jacobian J solves
///   (M + h J' [normal_damping n n' + tangential_damping (1 - n n')] J) u+ = ...
/// with a matrix that is symmetric and positive definite for every h > 0.
struct LinearisedContact {
  bool presses = false;           // false: no force at all
  double normal_offset = 0;       // N
  double normal_damping = 0;      // N s/m
  double bristle_gain = 0;        // N/m
  double tangential_damping = 0;  // N s/m
  double decay = 1;               // D = 1 + h alpha sigma0 |v| / g, >= 1
};

/// The friction part at a guess of the step's end: `normal_force` [N], sliding `speed` [m/s],
/// length of the elastic trial |z + h v| [m] and whether that trial points along v. With
/// law.return_map the decay is at least what keeps sigma0 |z+| <= mu_s Fn.
void linearise_friction(const TexelLaw& law, double h, double normal_force, double speed,
                        double trial_length, bool outward, LinearisedContact& contact);

/// Linearises the law over a step of `h` [s] at a guess of the depth's rate [m/s] and of the
/// sliding velocity: take those of the step's start first, then once more those of the first
/// solution. A negative `depth` is a gap that may close within the step: the linear spring then
/// acts from where it closes, without damping, so that no spring energy appears that the body did
/// not bring.
template <typename Vector>
LinearisedContact linearise(const TexelLaw& law, double h, double depth, double rate_guess,
                            const Vector& bristle, const Vector& velocity_guess) {
  LinearisedContact contact;
  const NormalResponse normal = normal_response(law, depth + h * rate_guess, rate_guess);
  contact.normal_damping = h * normal.stiffness + (depth > 0 ? normal.damping : 0.0);
  const double damping_at_gap = depth > 0 ? 0.0 : normal.damping * rate_guess;
  const double force = normal.force - damping_at_gap;
  contact.normal_offset = force - contact.normal_damping * rate_guess;
  contact.presses = force > 0;
  if (!contact.presses) return contact;
  const Vector trial = bristle + h * velocity_guess;
  linearise_friction(law, h, force, velocity_guess.norm(), trial.norm(),
                     trial.dot(velocity_guess) > 0, contact);
  return contact;
}

/// z+ = (z + h v+) / D for a vector of either size.
template <typename Vector>
Vector advanced_bristle(const LinearisedContact& contact, double h, const Vector& bristle,
                        const Vector& velocity) {
  return (bristle + h * velocity) / contact.decay;
}

/// The bristle cut back to |sigma0 z| <= mu_s Fn.
template <typename Vector>
Vector return_mapped(const TexelLaw& law, double normal_force, const Vector& bristle) {
  const double limit = law.static_friction * normal_force / law.bristle_stiffness;
  const double length = bristle.norm();
  return length > limit ? Vector(bristle * (limit / length)) : bristle;
}

/// Forces and state after one step of prescribed motion.
struct TexelStep {
  double normal_force = 0;                                   // N
  Eigen::Vector2d friction_force = Eigen::Vector2d::Zero();  // Ft [N]
  Eigen::Vector2d bristle = Eigen::Vector2d::Zero();         // z+ [m]
};

/// One implicit step of a texel whose motion is prescribed: penetration `depth` [m] at the start of
/// the step, `depth_rate` and `velocity` [m/s] during it. @throws std::invalid_argument for h <= 0.
TexelStep implicit_step(const TexelLaw& law, double h, double depth, double depth_rate,
                        const Eigen::Vector2d& bristle, const Eigen::Vector2d& velocity);

}  // namespace prehend::contact
