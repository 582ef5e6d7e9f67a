#pragma once

#include <functional>
#include <string>
#include <vector>

#include "prehend/grasp/closing/close_fingers.h"
#include "prehend/grasp/closing/close_pads.h"
#include "prehend/grasp/closing/collision.h"
#include "prehend/grasp/generators/generator.h"
#include "prehend/grasp/uncertainty.h"
#include "prehend/text/knob.h"

namespace prehend::grasp {

/// What pads that close need to know, and how such grasps are weighed: the mean of these.
struct PadOptions {
  struct Weights {
    double quality = 0.35;      // epsilon / (epsilon + 0.05)
    double centredness = 0.35;  // exp(-d / 20 mm), d from the centre of mass to the pads' line
    double area = 0.2;          // mean patch area / pad area
    double clearance = 0.1;     // min(1, fingertips' height over the table / 20 mm)
  };
  ClosingOptions closing;
  Weights weights;
  double friction = 0.6;             // > 0, assumed; below the pads' mu_d to stay on the safe side
  double least_force = 8;            // N, > 0, per pad: less is not controllable
  double largest_force = 0;          // N, per pad; 0: what the gripper's nominal current gives
  double opening_clearance = 0.005;  // m, >= 0, of each pad when a narrower opening must do
  /// m, >= 0: sections that are too wide by up to this much are listed too, with a remark: the
  /// prediction may be wider than the object. They come last: nothing of them is robust.
  double width_tolerance = 0.006;
  double largest_offset = 0.004;  // m, >= 0, of the grasped section from the hand's middle

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"friction", self.friction, "", 1e-6, 10, "assumed between pads and objects"});
    visit(Knob{"least_force", self.least_force, "N", 0.1, 10000, "per pad"});
    visit(Knob{"largest_force", self.largest_force, "N", 0, 10000,
               "per pad; 0: by the gripper's nominal current"});
    visit(Knob{"opening_clearance", self.opening_clearance, "m", 0, 0.1,
               "of each pad on the approach, when a narrower opening must do"});
    visit(
        Knob{"width_tolerance", self.width_tolerance, "m", 0, 0.1,
             "sections that are too wide by up to this much are tried last: the prediction may be "
             "wider than the object"});
    visit(Knob{"largest_offset", self.largest_offset, "m", 0, 0.1,
               "of the grasped section from the hand's middle"});
  }

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// The same of fingers. Their friction is the hand's.
struct FingerOptions {
  struct Weights {
    double quality = 0.4;      // epsilon / (epsilon + 0.05)
    double margin = 0.3;       // disturbance margin / (it + the weight)
    double centredness = 0.2;  // exp(-d / 30 mm), d from the centre of mass to the contacts' mean
    double pads = 0.1;         // share of the contacts that are on pads, or on a hand without pads
  };
  HandClosingOptions closing;
  Weights weights;
  double largest_shortfall = 0.03;  // m, >= 0, by which the hand may be stopped before its standoff
  int least_fingers = 2;            // > 0, that must touch the object (the palm counts as one)
  bool volume = false;              // also Grasp::volume, some ms for each grasp in the result

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"largest_shortfall", self.largest_shortfall, "m", 0, 1,
               "by which the hand may be stopped before its standoff"});
    visit(Knob{"least_fingers", self.least_fingers, "", 1, 10,
               "that must touch the object; the palm counts as one"});
  }

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// A pose of the tool frame of a preshape.
struct HandCandidate {
  Candidate candidate;
  std::string preshape;  // by its name; empty: the hand's first
};

/// The defaults are those of a parallel gripper; default_options() has every hand's.
struct PlannerOptions {
  std::vector<std::string> generators{"circles", "boxes"};  // by name, at least one
  /// Tried as well when no grasp of the former holds in `enough` of its disturbed trials: walls,
  /// rims and handles of what is too wide.
  std::vector<std::string> further_generators{"antipodal"};
  double enough = 0;            // 0..1; 0: any grasp is
  GeneratorOptions candidates;  // how many of them
  /// Every candidate also turned by half a turn about the approach: of hands that are not
  /// symmetric.
  bool both_ways = false;
  std::vector<std::string> preshapes;  // of the hand's; empty: all of them
  /// Poses to try instead of what the generators make, if there are any; kGiven is their
  /// generator's name then.
  std::vector<HandCandidate> given_W;
  CollisionOptions collision;
  UncertaintyOptions uncertainty;
  int robust_count = 0;  // >= 0, of the best grasps, are assessed for robustness, the others count
                         // as if they never held; 0: all
  /// Candidates are tried in shares that are spread over all of them: one in `first_share`, then
  /// twice as many, until it is all. The next share is tried only while fewer than `largest_count`
  /// grasps are listed, or fewer than this many of them hold in kSure of their disturbed trials.
  /// >= 0; 0, or without such trials: all are.
  int enough_grasps = 4;
  int first_share = 4;  // > 0; 1: all
  static constexpr double kSure = 0.9;
  int cone_edges = 8;    // >= 3, of the linearised friction cones
  double density = 800;  // kg/m^3, > 0, assumed of the unknown object
  /// Part of `density` that is assumed of an object with which the hand could hold nothing: cartons
  /// and vessels are mostly air. 1: none is.
  double hollow_share = 0.375;      // 0..1, > 0
  double safety_factor = 2.5;       // >= 1, of the grasp force against slipping, or of the motors'
                                    // limits against what the load needs
  double lift_acceleration = 1.0;   // m/s^2, >= 0, upwards on top of gravity
  double pregrasp_distance = 0.08;  // m, > 0, back along the approach
  /// A grasp's mean of its closing's weights is multiplied by 1 - guessed + guessed (share of the
  /// contact that is on surface that is there, by vertex_confidence), ...
  double guessed_weight = 0.5;  // 0..1
  /// ... and by 1 - robust + robust Grasp.robustness.
  double robust_weight = 0.9;  // 0..1
  int largest_count = 32;      // > 0, of grasps in the result
  /// s of wall time, >= 0: candidates, spread over all of them, are tried until it is used up; 0:
  /// all are. With a budget the result depends on how fast the machine is.
  double budget = 0;
  int threads = 0;  // >= 0; 0: all cores. The result does not depend on it
  /// Whether the arm reaches a pose of the hand's root; asked for the grasp and for the pregrasp
  /// (of a parallel gripper for both turned by half about the approach, too), by several threads at
  /// once. Empty: it reaches all. Must give the same answer for the same pose.
  std::function<bool(const geometry::RigidTransform& X_WH)> reaches;
  PadOptions pads;        // of a parallel gripper with pads
  FingerOptions fingers;  // of every other hand

  /// Of every hand; `pads` and `fingers` have their own. See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"density", self.density, "kg/m^3", 1, 1e6, "assumed of the objects"});
    visit(Knob{"hollow_share", self.hollow_share, "", 0.01, 1,
               "of the density, assumed of an object that would be too heavy for the hand: cartons "
               "and vessels are mostly air; 1: none is"});
    visit(Knob{"safety_factor", self.safety_factor, "", 1, 100,
               "of the grasp force against slipping, or of the motors' limits against the load"});
    visit(Knob{"lift_acceleration", self.lift_acceleration, "m/s^2", 0, 100,
               "upwards on top of gravity, that a grasp must bear"});
    visit(Knob{"pregrasp_distance", self.pregrasp_distance, "m", 0.01, 1,
               "back along the approach direction"});
    visit(Knob{"table_margin", self.collision.table_margin, "m", 0, 0.1, "between hand and table"});
    visit(Knob{"object_margin", self.collision.object_margin, "m", 0, 0.1,
               "between the open hand and the object"});
    visit(Knob{"obstacle_margin", self.collision.obstacle_margin, "m", 0, 0.5,
               "between hand and other objects"});
    visit(Knob{"robustness_samples", self.uncertainty.samples, "", 0, 10000,
               "disturbed poses and frictions in which each listed grasp is tried; 0: not at all"});
    visit(Knob{"position_deviation", self.uncertainty.position_deviation, "m", 0, 0.1,
               "standard, of the hand in the object, when it is tried so"});
    visit(Knob{"rotation_deviation", self.uncertainty.rotation_deviation, "rad", 0, 1.6,
               "standard, about each axis, when it is tried so"});
    visit(Knob{"robust_count", self.robust_count, "", 0, 100000,
               "of the best grasps are tried so, the others count as if they never held; 0: all"});
    visit(
        Knob{"enough_grasps", self.enough_grasps, "", 0, 100000,
             "once a plan is full and so many of it hold in nine of ten of these trials, the other "
             "candidates are not tried; 0: all are"});
    visit(Knob{"first_share", self.first_share, "", 1, 100000,
               "one of so many candidates is tried before it is asked whether these are enough, "
               "then twice as many and so on; 1: all"});
    visit(Knob{"robust_weight", self.robust_weight, "", 0, 1,
               "of the share of these trials in which a grasp holds, in its score"});
    visit(Knob{"guessed_weight", self.guessed_weight, "", 0, 1,
               "of contact on surface that nobody saw, against a grasp's score"});
    visit(Knob{"largest_count", self.largest_count, "", 1, 10000, "of grasps in a plan"});
    visit(Knob{"budget", self.budget, "s", 0, 3600,
               "for the grasps of one object: the best setting of the front within it, which ends "
               "planning in any case; 0: as long as it takes"});
  }

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// What is a good start for this hand: with fingers fewer candidates in more ways.
PlannerOptions default_options(const robot::HandModel& hand);

}  // namespace prehend::grasp
