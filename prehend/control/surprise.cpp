#include "prehend/control/surprise.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace prehend::control {

std::string to_string(SurpriseKind kind) {
  switch (kind) {
    case SurpriseKind::kOpeningAtContact:
      return "opening at contact";
    case SurpriseKind::kContactArea:
      return "contact area";
    case SurpriseKind::kTactileSum:
      return "tactile sum";
    case SurpriseKind::kHeldAfterLift:
      return "held after lift";
    case SurpriseKind::kTouchedTooEarly:
      return "touched too early";
    case SurpriseKind::kFingersTouch:
      return "fingers touch";
    case SurpriseKind::kFingersAtContact:
      return "fingers at contact";
    case SurpriseKind::kLiftedWeight:
      return "lifted weight";
    case SurpriseKind::kHeldWhileCarried:
      return "held while carried";
    case SurpriseKind::kPlaced:
      return "placed";
    case SurpriseKind::kMotion:
      return "motion";
    case SurpriseKind::kSlip:
      return "slip while held";
  }
  return "unknown";
}

std::string unit_of(SurpriseKind kind) {
  switch (kind) {
    case SurpriseKind::kOpeningAtContact:
    case SurpriseKind::kSlip:
      return "m";
    case SurpriseKind::kContactArea:
      return "m^2";
    case SurpriseKind::kTactileSum:
    case SurpriseKind::kTouchedTooEarly:
    case SurpriseKind::kLiftedWeight:
      return "N";
    case SurpriseKind::kFingersAtContact:
      return "rad";
    case SurpriseKind::kHeldAfterLift:
    case SurpriseKind::kFingersTouch:
    case SurpriseKind::kHeldWhileCarried:
    case SurpriseKind::kPlaced:
    case SurpriseKind::kMotion:
      return "";
  }
  return "";
}

void SurpriseTolerances::validate() const { knobs(*this, text::CheckKnobs{"SurpriseTolerances."}); }

double tolerance_of(SurpriseKind kind, double predicted, const SurpriseTolerances& tolerances) {
  switch (kind) {
    case SurpriseKind::kOpeningAtContact:
      return tolerances.opening;
    case SurpriseKind::kContactArea:
      return std::max(tolerances.area, tolerances.area_ratio * std::abs(predicted));
    case SurpriseKind::kTactileSum:
      return std::max(tolerances.tactile_sum, tolerances.tactile_sum_ratio * std::abs(predicted));
    case SurpriseKind::kFingersAtContact:
      return tolerances.fingers;
    case SurpriseKind::kLiftedWeight:
      return std::max(tolerances.weight, tolerances.weight_ratio * std::abs(predicted));
    case SurpriseKind::kHeldAfterLift:
    case SurpriseKind::kFingersTouch:
    case SurpriseKind::kHeldWhileCarried:
    case SurpriseKind::kPlaced:
    case SurpriseKind::kMotion:
      return 0.5;
    case SurpriseKind::kTouchedTooEarly:
    case SurpriseKind::kSlip:
      return 0;
  }
  throw std::invalid_argument("tolerance_of: unknown kind of surprise");
}

Surprise compare(SurpriseKind kind, double predicted, double felt,
                 const SurpriseTolerances& tolerances, const std::string& reaction_if_surprising) {
  Surprise surprise{kind, predicted, felt, tolerance_of(kind, predicted, tolerances), false, ""};
  surprise.surprising = !(std::abs(felt - predicted) <= surprise.tolerance);  // NaN surprises
  surprise.reaction = surprise.surprising ? reaction_if_surprising : "carry on";
  return surprise;
}

}  // namespace prehend::control
