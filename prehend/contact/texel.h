#pragma once

#include <Eigen/Core>

#include "prehend/contact/texel_law.h"

/// The soft contact law of texel_law.h as pure functions: the paper's explicit form, which serves
/// as oracle, and the implicit step that a body solver folds into its system of equations.
///
/// Signs: `depth` d > 0 is penetration [m], `depth_rate` its rate [m/s]; `velocity` v is the
/// tangential velocity of the touched body relative to the texel [m/s]; friction on the touched
/// body is -Ft. Everything tangential is a scalar times a vector, so the functions below hold for
/// 2-vectors in the texel's plane as well as for 3-vectors of that plane in space.
namespace prehend::contact {

/// Checks the constants of `law`. @throws std::invalid_argument naming the field: NaN or infinity
/// anywhere, a negative constant, a stiffness or Stribeck velocity that is not positive, or
/// dynamic_friction above static_friction.
void validate(const TexelLaw& law);

/// True when the law cannot create energy: sigma2 > sigma1 (mu_s - mu_d) / mu_d, or mu_s == mu_d
/// (Olsson, "Control Systems with Friction", 1996, LuGre passivity).
bool is_passive(const TexelLaw& law);

/// Fn = max(0, k d + c dd/dt) [N]; zero without penetration.
double normal_force(const TexelLaw& law, double depth, double depth_rate);

/// g = Fn [mu_d + (mu_s - mu_d) exp(-(v/v_s)^2)] [N], the friction of steady sliding at `speed`
/// without the viscous part.
double stribeck_force(const TexelLaw& law, double normal_force, double speed);

/// Bristle rate dz/dt = v - sigma0 |v| / g(v) z [m/s] of the paper's law. Zero normal force: the
/// bristle has nothing to hold, the rate is `velocity`.
Eigen::Vector2d bristle_rate(const TexelLaw& law, const Eigen::Vector2d& bristle,
                             const Eigen::Vector2d& velocity, double normal_force);

/// Ft = sigma0 z + sigma1 dz/dt + sigma2 v [N].
Eigen::Vector2d friction_force(const TexelLaw& law, const Eigen::Vector2d& bristle,
                               const Eigen::Vector2d& bristle_rate,
                               const Eigen::Vector2d& velocity);

/// The law over one step of length h as affine functions of the velocities at its end:
///   Fn+ = normal_offset + normal_damping dd/dt+          (k d, and h k + c)
///   Ft+ = bristle_gain z + tangential_damping v+
///   z+  = (z + h v+) / decay
/// so that a body with mass M and contact Jacobian J solves
///   (M + h J' [normal_damping n n' + tangential_damping (1 - n n')] J) u+ = ...
/// with a matrix that is symmetric and positive definite for every h > 0.
struct LinearisedContact {
  double normal_offset = 0;       // N
  double normal_damping = 0;      // N s/m
  double bristle_gain = 0;        // N/m
  double tangential_damping = 0;  // N s/m
  double decay = 1;               // D = 1 + h sigma0 |v| / g, >= 1
};

/// Linearises the law over a step of `h` [s], with D and g frozen at a guess of the normal force
/// [N] and of the sliding speed |v| [m/s]: take those of the step's start first, then once more
/// those of the first solution. A guess of no normal force gives no friction. A negative `depth` is
/// a gap that may close within the step: the spring then acts from where it closes, without
/// damping, so that no spring energy appears that the body did not bring.
LinearisedContact linearise(const TexelLaw& law, double h, double depth, double normal_force_guess,
                            double speed_guess);

/// z+ = (z + h v+) / D for a vector of either size.
template <typename Vector>
Vector advanced_bristle(const LinearisedContact& contact, double h, const Vector& bristle,
                        const Vector& velocity) {
  return (bristle + h * velocity) / contact.decay;
}

/// The bristle cut back to |sigma0 z| <= mu_s Fn. The paper's law keeps a bristle longer than that
/// when a contact is unloaded without sliding; with this return map friction never exceeds the
/// static limit. Off in the oracle, on in the simulation.
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
