#include "prehend/contact/texel.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "prehend/contact/compression_curve.h"
#include "prehend/contact/require.h"

namespace prehend::contact {
void validate(const TexelLaw& law) {
  require_positive(law.stiffness, "TexelLaw::stiffness");
  require_not_negative(law.damping, "TexelLaw::damping");
  require_positive(law.bristle_stiffness, "TexelLaw::bristle_stiffness");
  require_not_negative(law.bristle_damping, "TexelLaw::bristle_damping");
  require_not_negative(law.viscous_friction, "TexelLaw::viscous_friction");
  require_not_negative(law.static_friction, "TexelLaw::static_friction");
  require_not_negative(law.dynamic_friction, "TexelLaw::dynamic_friction");
  require(law.dynamic_friction <= law.static_friction, "TexelLaw::dynamic_friction",
          "at most static_friction");
  require_positive(law.stribeck_velocity, "TexelLaw::stribeck_velocity");
  require(law.exponent >= 1 && law.exponent <= 4, "TexelLaw::exponent", "from 1 to 4");
  require(law.elastic_limit >= 0 && law.elastic_limit < 1, "TexelLaw::elastic_limit",
          "from 0 to below 1");
  require(law.normal_law != NormalLaw::kTabulated || law.curve != nullptr, "TexelLaw::curve",
          "given for the tabulated law");
  for (const FoamMemory::Creep& term : law.memory.creep) {
    require_positive(term.share, "TexelLaw::creep: share");
    require_positive(term.time, "TexelLaw::creep: time");
  }
  for (const FoamMemory::Hysteresis& term : law.memory.hysteresis) {
    require_positive(term.share, "TexelLaw::hysteresis: share");
    require_positive(term.depth, "TexelLaw::hysteresis: depth");
  }
  require(law.memory.terms() <= FoamMemory::kMostTerms, "TexelLaw::creep and hysteresis",
          "8 terms at most");
  require(law.memory.terms() == 0 || law.normal_law != NormalLaw::kHuntCrossley,
          "TexelLaw::normal_law", "linear or tabulated for a foam with creep or hysteresis");
}

double least_passive_viscous_friction(const TexelLaw& law) {
  const double excess = law.static_friction - law.dynamic_friction;
  if (excess == 0) return 0;
  require(law.dynamic_friction > 0, "TexelLaw::dynamic_friction",
          "positive for a passive law whose static_friction is larger");
  return law.bristle_damping * excess / law.dynamic_friction;
}

bool is_passive(const TexelLaw& law) {
  const double excess = law.static_friction - law.dynamic_friction;
  return excess == 0 || law.viscous_friction * law.dynamic_friction > law.bristle_damping * excess;
}

NormalResponse normal_response(const TexelLaw& law, double depth, double depth_rate) {
  switch (law.normal_law) {
    case NormalLaw::kLinear:
      return {law.stiffness * depth + law.damping * depth_rate, law.stiffness, law.damping};
    case NormalLaw::kHuntCrossley: {
      if (depth <= 0) return {};
      const double slope = std::pow(depth, law.exponent - 1), power = depth * slope;
      const double modulus = std::max(0.0, law.stiffness + law.damping * depth_rate);
      return {power * modulus, law.exponent * slope * modulus, power * law.damping};
    }
    case NormalLaw::kTabulated:
      if (depth <= 0) return {};
      return {law.curve->force(depth) + law.damping * depth_rate, law.curve->stiffness(depth),
              law.damping};
  }
  return {};
}

double normal_force(const TexelLaw& law, double depth, double depth_rate) {
  if (depth <= 0) return 0;
  return std::max(0.0, normal_response(law, depth, depth_rate).force);
}

double stribeck_force(const TexelLaw& law, double normal_force, double speed) {
  const double ratio = speed / law.stribeck_velocity;
  const double excess = law.static_friction - law.dynamic_friction;
  return normal_force * (law.dynamic_friction + excess * std::exp(-ratio * ratio));
}

double plasticity(const TexelLaw& law, double load, bool outward) {
  if (law.bristle_law == BristleLaw::kLuGre) return 1;
  if (!outward) return 0;
  const double t = std::clamp((load - law.elastic_limit) / (1 - law.elastic_limit), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

Eigen::Vector2d bristle_rate(const TexelLaw& law, const Eigen::Vector2d& bristle,
                             const Eigen::Vector2d& velocity, double normal_force) {
  const double speed = velocity.norm();
  const double g = stribeck_force(law, normal_force, speed);
  if (g <= 0) return velocity;
  const double alpha =
      plasticity(law, law.bristle_stiffness * bristle.norm() / g, bristle.dot(velocity) > 0);
  return velocity - alpha * law.bristle_stiffness * speed / g * bristle;
}

Eigen::Vector2d friction_force(const TexelLaw& law, const Eigen::Vector2d& bristle,
                               const Eigen::Vector2d& bristle_rate,
                               const Eigen::Vector2d& velocity) {
  return law.bristle_stiffness * bristle + law.bristle_damping * bristle_rate +
         law.viscous_friction * velocity;
}

void linearise_friction(const TexelLaw& law, double h, double normal_force, double speed,
                        double trial_length, bool outward, LinearisedContact& contact) {
  const double g = stribeck_force(law, normal_force, speed);
  if (g <= 0) return;
  const double load = law.bristle_stiffness * trial_length;
  contact.decay = 1 + plasticity(law, load / g, outward) * h * law.bristle_stiffness * speed / g;
  if (law.return_map) {
    contact.decay = std::max(contact.decay, load / (law.static_friction * normal_force));
  }
  // Ft = sigma0 z+ + sigma1 (z+ - z) / h + sigma2 v+  with  z+ = (z + h v+) / D
  contact.bristle_gain =
      (law.bristle_stiffness + law.bristle_damping / h) / contact.decay - law.bristle_damping / h;
  contact.tangential_damping =
      (h * law.bristle_stiffness + law.bristle_damping) / contact.decay + law.viscous_friction;
}

TexelStep implicit_step(const TexelLaw& law, double h, double depth, double depth_rate,
                        const Eigen::Vector2d& bristle, const Eigen::Vector2d& velocity) {
  if (!(h > 0)) throw std::invalid_argument("implicit_step: the step h must be positive");
  TexelStep step;
  if (depth <= 0) return step;
  const LinearisedContact contact = linearise(law, h, depth, depth_rate, bristle, velocity);
  if (!contact.presses) return step;
  step.normal_force = contact.normal_offset + contact.normal_damping * depth_rate;
  step.friction_force = contact.bristle_gain * bristle + contact.tangential_damping * velocity;
  step.bristle = advanced_bristle(contact, h, bristle, velocity);
  if (law.return_map) step.bristle = return_mapped(law, step.normal_force, step.bristle);
  return step;
}

}  // namespace prehend::contact
