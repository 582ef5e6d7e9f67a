#include <cmath>
#include <stdexcept>

#include "prehend/control/grasp_cycle.h"

#include "prehend/text/require.h"

namespace prehend::control {

void CycleOptions::validate() const {
  SharedCycleOptions::validate();
  const text::Require require{"CycleOptions."};
  require(std::abs(up_W.norm() - 1) < 1e-6, "up_W must be a unit vector");
  require(std::isfinite(transit_height), "transit_height must be finite");
  require(travel_speed > 0, "travel_speed must be positive");
  require(approach_speed > 0, "approach_speed must be positive");
  require(lift_speed > 0, "lift_speed must be positive");
  require(opening_speed > 0, "opening_speed must be positive");
  require(closing_speed > 0, "closing_speed must be positive");
  require(fast_closing_speed > 0, "fast_closing_speed must be positive");
  require(closing_margin >= 0, "closing_margin must not be negative");
  require(pressing_speed > 0, "pressing_speed must be positive");
  require(contact_force > 0, "contact_force must be positive");
  require(touch_force > 0, "touch_force must be positive");
  require(held_ratio >= 0 && held_ratio < 1, "held_ratio must be in [0, 1)");
  require(largest_collapse > 0, "largest_collapse must be positive");
  require(largest_excess >= 1, "largest_excess must be at least 1");
  require(least_share > 0 && least_share <= 1, "least_share must be in (0, 1]");
  require(settled_time >= 0, "settled_time must not be negative");
  require(check_time >= 0, "check_time must not be negative");
  require(lift_height >= 0.12, "lift_height must be at least 0.12 m");
  require(move_W.allFinite(), "move_W must be finite");
  require(motion_timeout > 0, "motion_timeout must be positive");
  require(closing_timeout > 0, "closing_timeout must be positive");
  require(force_timeout > 0, "force_timeout must be positive");
  force.validate();
}

}  // namespace prehend::control
