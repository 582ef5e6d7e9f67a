#pragma once

#include <string>

#include "prehend/text/knob.h"

namespace prehend::control {

/// What was predicted and is compared with what is felt; same order as msgs.Surprise.Kind.
enum class SurpriseKind {
  kOpeningAtContact,  // m
  kContactArea,       // m^2
  kTactileSum,        // N
  kHeldAfterLift,     // 1 held, 0 not
  kTouchedTooEarly,   // N at the wrist while approaching, or high above where the object is put
  kFingersTouch,      // 1 fingers, or both pads, met something when they closed, 0 not
  kFingersAtContact,  // rad, mean, that the fingers closed beyond the predicted touch
  kLiftedWeight,      // N
  kHeldWhileCarried,  // 1 held until it was lowered, 0 lost on the way
  kPlaced,            // 1 the hand is empty after it has opened at the place, 0 not
  kMotion,            // 1 a motion ended as planned, 0 not
  kSlip,              // m, that what is held has slid over the pads
};

/// "contact area", "held after lift", ...
std::string to_string(SurpriseKind kind);
/// Of what is compared: "m", "m^2", "N", "rad"; "" for what is 1 or 0.
std::string unit_of(SurpriseKind kind);

/// A prediction against what was felt.
struct Surprise {
  SurpriseKind kind = SurpriseKind::kOpeningAtContact;
  double predicted = 0;
  double felt = 0;
  double tolerance = 0;
  bool surprising = false;  // |felt - predicted| > tolerance, or one of them is not finite
  std::string reaction;     // what the cycle does about it
};

/// How far what is felt may be from what was predicted: the larger of the absolute and the relative
/// tolerance. The contact area's is wide as single texels at a patch's edge come and go.
struct SurpriseTolerances {
  double opening = 0.006;          // m
  double area = 1.5e-4;            // m^2, 13 texels of 3.4 mm
  double area_ratio = 0.5;         // of the predicted area
  double tactile_sum = 1.0;        // N
  double tactile_sum_ratio = 0.2;  // of the predicted sum
  double fingers = 0.2;            // rad
  double weight = 1;               // N
  double weight_ratio = 1;         // of the predicted weight: its density is a guess

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"opening", self.opening, "m", 0, 1, "tolerance of the opening at contact"});
    visit(Knob{"area", self.area, "m^2", 0, 1, "tolerance of the contact area"});
    visit(Knob{"area_ratio", self.area_ratio, "", 0, 100,
               "the same, of the predicted area; the larger counts"});
    visit(Knob{"tactile_sum", self.tactile_sum, "N", 0, 1000, "tolerance of the pads' mean sum"});
    visit(Knob{"tactile_sum_ratio", self.tactile_sum_ratio, "", 0, 100,
               "the same, of the predicted sum; the larger counts"});
    visit(Knob{"fingers", self.fingers, "rad", 0, 3.2, "tolerance of where fingers stop"});
    visit(Knob{"weight", self.weight, "N", 0, 1000, "tolerance of the weight"});
    visit(Knob{"weight_ratio", self.weight_ratio, "", 0, 100,
               "the same, of the predicted weight; the larger counts"});
  }

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// The tolerance of `kind` for a prediction; 0.5 for what is 1 or 0, 0 for kTouchedTooEarly
/// and kSlip.
double tolerance_of(SurpriseKind kind, double predicted, const SurpriseTolerances& tolerances);

/// Compares; `reaction_if_surprising` is said only when it is a surprise, else "carry on".
Surprise compare(SurpriseKind kind, double predicted, double felt,
                 const SurpriseTolerances& tolerances, const std::string& reaction_if_surprising);

}  // namespace prehend::control
