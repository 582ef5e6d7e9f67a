#include "prehend/simulation/power_screw.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "prehend/contact/require.h"

namespace prehend::simulation {
namespace {

constexpr double kPi = std::numbers::pi;

// Friction of a flat flank that does the same: the normal force on a slanted one is larger.
double flat_friction(const PowerScrew& screw) {
  return screw.friction / std::cos(screw.flank_angle);
}

}  // namespace

double PowerScrew::raising_torque() const {
  const double f = flat_friction(*this), d = mean_diameter;
  const double below = kPi * d - f * lead;
  if (below <= 0) return std::numeric_limits<double>::infinity();
  return 0.5 * d * (lead + kPi * f * d) / below;
}

double PowerScrew::lowering_torque() const {
  const double f = flat_friction(*this), d = mean_diameter;
  return 0.5 * d * (kPi * f * d - lead) / (kPi * d + f * lead);
}

double PowerScrew::efficiency() const { return lead / (2 * kPi * raising_torque()); }

bool PowerScrew::is_self_locking() const {
  return kPi * flat_friction(*this) * mean_diameter > lead;
}

double PowerScrew::friction_against_load() const { return 1 / efficiency() - 1; }

double PowerScrew::friction_along_load() const { return 1 + 2 * kPi * lowering_torque() / lead; }

void validate(const PowerScrew& screw, const char* owner) {
  using contact::require;
  using contact::require_not_negative;
  using contact::require_positive;
  const std::string prefix = std::string(owner) + ".";
  require_positive(screw.lead, prefix + "lead");
  require_positive(screw.mean_diameter, prefix + "mean_diameter");
  require_not_negative(screw.friction, prefix + "friction");
  require(screw.flank_angle >= 0 && screw.flank_angle < 0.5 * kPi, prefix + "flank_angle",
          "from 0 to below pi/2");
  require(
      std::isfinite(screw.raising_torque()), prefix + "friction",
      "below what locks the screw in both directions, pi mean_diameter cos(flank_angle) / lead");
}

}  // namespace prehend::simulation
