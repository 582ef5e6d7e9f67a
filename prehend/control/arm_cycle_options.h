#pragma once

#include "prehend/control/cycle.h"
#include "prehend/control/holding.h"
#include "prehend/robot/grip.h"
#include "prehend/text/knob.h"
#include "prehend/touch/hold_slip.h"

namespace prehend::control {

/// How ArmCycle reacts. In knobs() each says what it does.
struct ArmCycleOptions : SharedCycleOptions, robot::GripOptions {
  /// The arm stops where the hand touches while it approaches (UJI's platform), jaws whose pads are
  /// beside the object by then go back a little and close there (`largest_shortfall`), and fingers
  /// that close on something beside its prediction put the hand in its middle and close again,
  /// where the plan has ArmGrasp::shifts; otherwise the plan is executed without looking (KTH's:
  /// open loop).
  bool reacts = false;
  double contact_force = 5;     // N
  double collision_force = 60;  // N
  double opening_speed = 0.6;
  double rest_time = 0.2;            // s
  double check_time = 0.4;           // s
  double motion_timeout = 60;        // s
  double largest_detour = 0.5;       // rad
  double largest_shortfall = 0.012;  // m
  double shift_tolerance = 0.006;    // m
  int adaptations = 2;
  double small_opening = 0.25;  // rad
  double minimum_stability = 0;
  double slip_force_factor = 1.5;
  double largest_grip_force = 0;  // N
  double slip_settle_time = 0.1;  // s
  double largest_slide = 0.008;   // m
  double probe_force = 1;         // N
  double push_force = 40;         // N
  HoldingOptions holding;
  touch::HoldSlipOptions slip;

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"contact_force", self.contact_force, "N", 0.1, 1000,
               "at the wrist, that counts as contact on the approach"});
    visit(Knob{
        "collision_force", self.collision_force, "N", 1, 10000,
        "at the wrist, on every other way, beyond what is held, and on the lift beyond what the "
        "closed fingers press on the table until that is gone: the arm has hit something and "
        "stops"});
    visit(Knob{"opening_speed", self.opening_speed, "", 0.01, 1,
               "of the hand, share of its joints' greatest"});
    visit(Knob{"rest_time", self.rest_time, "s", 0, 10,
               "before the approach: the wrist's force at rest, its noise"});
    visit(Knob{"check_time", self.check_time, "s", 0, 10,
               "at rest after the lift, and after the retreat"});
    visit(Knob{"motion_timeout", self.motion_timeout, "s", 1, 3600, "of each motion"});
    visit(Knob{"largest_detour", self.largest_detour, "rad", 0.001, 3.2,
               "that a path may begin away from where the arm stands"});
    visit(
        Knob{"largest_shortfall", self.largest_shortfall, "m", 0, 0.1,
             "with reacts, of a gripper that regulates its grip: jaws that touch something on the "
             "approach no farther than this before its end go back a little and close there, and "
             "farther off close where a pad feels it; 0: they let go"});
    visit(Knob{"shift_tolerance", self.shift_tolerance, "m", 0.0005, 0.1,
               "with reacts: a thing that the fingers feel this much beside its prediction is not "
               "in the hand's middle"});
    visit(Knob{"adaptations", self.adaptations, "", 0, 20,
               "with reacts: times that fingers let go, the hand is shifted to the middle of what "
               "they felt, and they close again; 0: they grip where they touch"});
    visit(
        Knob{"small_opening", self.small_opening, "rad", 0.01, 3.2,
             "that fingers open from where they gripped, when the hand has opened all the way and "
             "takes along what it has put down: it is put back, and left so"});
    visit(
        Knob{"minimum_stability", self.minimum_stability, "", 0, 1,
             "probability that the lift holds, by what the pads feel when the hand has closed and "
             "again when it has risen by 10 mm, below which it presses harder where that helps, "
             "else lets go and looks again; 0: it is said and changes nothing"});
    visit(Knob{"slip_force_factor", self.slip_force_factor, "", 1, 10,
               "times the force, that is held with when the pads feel that what is held slips, as "
               "often as it does; 1: it is said and changes nothing"});
    visit(Knob{"largest_grip_force", self.largest_grip_force, "N", 0, 1000,
               "per pad, that the object bears: what slips is not held harder; 0: what the motors "
               "give"});
    visit(Knob{"probe_force", self.probe_force, "N", 0.1, 100,
               "at the wrist, at which a fingertip that probes the object is stopped; a pad that "
               "touches stops it, too"});
    visit(Knob{"push_force", self.push_force, "N", 1, 1000,
               "at the wrist, at which a push along the table is stopped"});
    visit(Knob{"slip_settle_time", self.slip_settle_time, "s", 0, 10,
               "for the force to rise, before it is watched again whether what is held slips"});
    visit(
        Knob{"largest_slide", self.largest_slide, "m", 0, 0.5,
             "over the pads, since it was lifted, of what cannot be held harder: beyond it, it is "
             "put down while it is lifted, up to it, most comes to rest"});
  }

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

}  // namespace prehend::control
