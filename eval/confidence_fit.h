#pragma once

#include <string>
#include <vector>

#include "prehend/shape/confidence.h"

namespace prehend::eval {

/// What the view said of one completion, and whether it was right.
struct JudgedEvidence {
  shape::Evidence evidence;
  bool right = false;
  std::string object;  // whose views are alike: cross-validation leaves out all of them together
};

/// The confidence model under which the judged completions are most likely: logistic regression
/// (by projected gradient steps, since every coefficient but the methods' is >= 0, and each method
/// is trusted less than the one before it) with a weak
/// Gaussian prior, of standard deviation `prior_width`, about `start`, so that what the data say
/// nothing of stays as it was. Deterministic.
/// @throws std::invalid_argument without any judged completion.
shape::ConfidenceModel fitted_confidence(const std::vector<JudgedEvidence>& judged,
                                         const shape::ConfidenceModel& start = {},
                                         double prior_width = 2);

/// The confidence in each completion under the model that is fitted to all but its own object's.
std::vector<double> cross_validated(const std::vector<JudgedEvidence>& judged,
                                    const shape::ConfidenceModel& start = {},
                                    double prior_width = 2);

/// The model as a YAML map that read_confidence_model() reads.
std::string to_yaml(const shape::ConfidenceModel& model);

/// Of the completions of at least some confidence: how many there are and how many are right; and
/// of how many that are right in all.
struct Calibration {
  int sure = 0;
  int right = 0;
  int all_right = 0;
};
Calibration calibration_of(const std::vector<JudgedEvidence>& judged,
                           const std::vector<double>& confidences, double least);
Calibration calibration_of(const std::vector<JudgedEvidence>& judged,
                           const shape::ConfidenceModel& model, double least);

}  // namespace prehend::eval
