#pragma once

#include <string>
#include <vector>

#include "eval/grasp/grasp_case.h"

namespace prehend::eval {

/// A first attempt: in which share of its disturbed trials the grasp held, and whether it lifted.
struct KnownSuccess {
  double held = 0;
  bool lifted = false;
  std::string object;  // all its views are left out together
};

/// The first attempts on predicted shapes whose grasp was assessed, of objects that fit the hand.
std::vector<KnownSuccess> first_attempts(const std::vector<GraspCase>& cases);

/// Probability of success where a grasp holds in none of its trials and in all; in between in
/// proportion (planning::DecisionOptions::success_of_none and success_of_all).
struct SuccessLine {
  double of_none = 0, of_all = 0;
  double at(double held) const { return of_none + held * (of_all - of_none); }
};

/// The line under which the attempts are likeliest, in steps of 0.005, not falling. One success and
/// one failure of each end are added, so that no probability is 0 or 1 for want of attempts.
SuccessLine fit_success(const std::vector<KnownSuccess>& known);

/// How well probabilities foretell.
struct SuccessCalibration {
  int attempts = 0, lifted = 0;
  double calibration_error = 0;  // expected, over five bins of as many attempts
  double brier = 0;              // mean squared error
  double brier_of_constant = 0;  // the same of the share that was lifted
};

/// Of each attempt by the line of the other objects.
SuccessCalibration cross_validated(const std::vector<KnownSuccess>& known);
/// Of each by this line.
SuccessCalibration calibration_of(const std::vector<KnownSuccess>& known, const SuccessLine& line);

}  // namespace prehend::eval
