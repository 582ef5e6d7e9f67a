#include "prehend/grasp/planner_options.h"

#include "prehend/text/require.h"

namespace prehend::grasp {

void PadOptions::validate() const {
  const text::Require require{"PadOptions."};
  closing.validate();
  knobs(*this, text::CheckKnobs{"PadOptions."});
  const Weights& w = weights;
  require(w.quality >= 0 && w.centredness >= 0 && w.area >= 0 && w.clearance >= 0 &&
              w.quality + w.centredness + w.area + w.clearance > 0,
          "weights must not be negative, nor all zero");
}

void FingerOptions::validate() const {
  const text::Require require{"FingerOptions."};
  closing.validate();
  knobs(*this, text::CheckKnobs{"FingerOptions."});
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
  knobs(*this, text::CheckKnobs{"PlannerOptions."});
  require(cone_edges >= 3, "cone_edges must be at least 3");
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
