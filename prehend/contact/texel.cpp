#include "prehend/contact/texel.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace prehend::contact {
namespace {

void require(bool condition, const char* field, const char* rule) {
  if (!condition) {
    throw std::invalid_argument(std::string("TexelLaw::") + field + " must be " + rule);
  }
}

void require_not_negative(double value, const char* field) {
  require(std::isfinite(value) && value >= 0, field, "finite and not negative");
}

void require_positive(double value, const char* field) {
  require(std::isfinite(value) && value > 0, field, "finite and positive");
}

}  // namespace

void validate(const TexelLaw& law) {
  require_positive(law.stiffness, "stiffness");
  require_not_negative(law.damping, "damping");
  require_positive(law.bristle_stiffness, "bristle_stiffness");
  require_not_negative(law.bristle_damping, "bristle_damping");
  require_not_negative(law.viscous_friction, "viscous_friction");
  require_not_negative(law.static_friction, "static_friction");
  require_not_negative(law.dynamic_friction, "dynamic_friction");
  require(law.dynamic_friction <= law.static_friction, "dynamic_friction",
          "at most static_friction");
  require_positive(law.stribeck_velocity, "stribeck_velocity");
}

bool is_passive(const TexelLaw& law) {
  const double excess = law.static_friction - law.dynamic_friction;
  return excess == 0 || law.viscous_friction * law.dynamic_friction > law.bristle_damping * excess;
}

double normal_force(const TexelLaw& law, double depth, double depth_rate) {
  if (depth <= 0) return 0;
  return std::max(0.0, law.stiffness * depth + law.damping * depth_rate);
}

double stribeck_force(const TexelLaw& law, double normal_force, double speed) {
  const double ratio = speed / law.stribeck_velocity;
  const double excess = law.static_friction - law.dynamic_friction;
  return normal_force * (law.dynamic_friction + excess * std::exp(-ratio * ratio));
}

Eigen::Vector2d bristle_rate(const TexelLaw& law, const Eigen::Vector2d& bristle,
                             const Eigen::Vector2d& velocity, double normal_force) {
  const double speed = velocity.norm();
  const double g = stribeck_force(law, normal_force, speed);
  if (g <= 0) return velocity;
  return velocity - law.bristle_stiffness * speed / g * bristle;
}

Eigen::Vector2d friction_force(const TexelLaw& law, const Eigen::Vector2d& bristle,
                               const Eigen::Vector2d& bristle_rate,
                               const Eigen::Vector2d& velocity) {
  return law.bristle_stiffness * bristle + law.bristle_damping * bristle_rate +
         law.viscous_friction * velocity;
}

LinearisedContact linearise(const TexelLaw& law, double h, double depth, double normal_force_guess,
                            double speed_guess) {
  LinearisedContact contact;
  contact.normal_offset = law.stiffness * depth;
  contact.normal_damping = h * law.stiffness + (depth > 0 ? law.damping : 0.0);
  const double g = stribeck_force(law, normal_force_guess, speed_guess);
  if (g <= 0) return contact;
  contact.decay = 1 + h * law.bristle_stiffness * speed_guess / g;
  // Ft = sigma0 z+ + sigma1 (z+ - z) / h + sigma2 v+  with  z+ = (z + h v+) / D
  contact.bristle_gain =
      (law.bristle_stiffness + law.bristle_damping / h) / contact.decay - law.bristle_damping / h;
  contact.tangential_damping =
      (h * law.bristle_stiffness + law.bristle_damping) / contact.decay + law.viscous_friction;
  return contact;
}

TexelStep implicit_step(const TexelLaw& law, double h, double depth, double depth_rate,
                        const Eigen::Vector2d& bristle, const Eigen::Vector2d& velocity) {
  if (!(h > 0)) throw std::invalid_argument("implicit_step: the step h must be positive");
  TexelStep step;
  if (depth <= 0) return step;
  const double end_force = law.stiffness * (depth + h * depth_rate) + law.damping * depth_rate;
  step.normal_force = std::max(0.0, end_force);
  if (step.normal_force == 0) return step;
  const LinearisedContact contact = linearise(law, h, depth, step.normal_force, velocity.norm());
  step.friction_force = contact.bristle_gain * bristle + contact.tangential_damping * velocity;
  step.bristle = advanced_bristle(contact, h, bristle, velocity);
  return step;
}

}  // namespace prehend::contact
