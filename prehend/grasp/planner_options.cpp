#include "prehend/grasp/planner_options.h"

#include "prehend/text/require.h"

namespace prehend::grasp {

void PadOptions::validate() const {
  const text::Require require{"PadOptions."};
  closing.validate();
  require(friction > 0, "friction must be positive");
  require(least_force > 0, "least_force must be positive");
  require(largest_force >= 0, "largest_force must not be negative");
  require(opening_clearance >= 0, "opening_clearance must not be negative");
  require(width_tolerance >= 0, "width_tolerance must not be negative");
  require(largest_offset >= 0, "largest_offset must not be negative");
  const Weights& w = weights;
  require(w.quality >= 0 && w.centredness >= 0 && w.area >= 0 && w.clearance >= 0 &&
              w.quality + w.centredness + w.area + w.clearance > 0,
          "weights must not be negative, nor all zero");
}

void FingerOptions::validate() const {
  const text::Require require{"FingerOptions."};
  closing.validate();
  require(largest_shortfall >= 0, "largest_shortfall must not be negative");
  require(least_fingers > 0, "least_fingers must be positive");
  const Weights& w = weights;
  require(w.quality >= 0 && w.margin >= 0 && w.centredness >= 0 && w.pads >= 0 &&
              w.quality + w.margin + w.centredness + w.pads > 0,
          "weights must not be negative, nor all zero");
}

void PlannerOptions::validate() const {
  const text::Require require{"PlannerOptions."};
  require(!generators.empty(), "generators must name at least one generator");
  require(enough >= 0 && enough <= 1, "enough must be within 0 and 1");
  candidates.validate();
  collision.validate();
  uncertainty.validate();
  require(robust_count >= 0, "robust_count must not be negative");
  require(cone_edges >= 3, "cone_edges must be at least 3");
  require(density > 0, "density must be positive");
  require(safety_factor >= 1, "safety_factor must be at least 1");
  require(lift_acceleration >= 0, "lift_acceleration must not be negative");
  require(pregrasp_distance > 0, "pregrasp_distance must be positive");
  require(guessed_weight >= 0 && guessed_weight <= 1, "guessed_weight must be within 0 and 1");
  require(robust_weight >= 0 && robust_weight <= 1, "robust_weight must be within 0 and 1");
  require(largest_count > 0, "largest_count must be positive");
  require(budget >= 0, "budget must not be negative");
  require(threads >= 0, "threads must not be negative");
  pads.validate();
  fingers.validate();
}

PlannerOptions default_options(const robot::HandModel& hand) {
  PlannerOptions options;
  if (hand.gripper) return options;
  options.generators = {"circles"};
  options.enough = 0.5;
  options.candidates.circles.directions_per_circle = 12;
  options.candidates.circles.rolls = 6;
  options.candidates.circles.standoffs = 3;
  options.candidates.circles.lateral_offsets = {0.0};
  options.candidates.samples = 40;
  options.both_ways = true;
  options.robust_count = 8;
  options.safety_factor = 1.5;
  options.pregrasp_distance = 0.1;
  return options;
}

}  // namespace prehend::grasp
