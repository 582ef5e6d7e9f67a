#pragma once

#include <string>
#include <vector>

#include "eval/belief/touch_trial.h"
#include "prehend/belief/shape_prior.h"

namespace prehend::eval {

/// How well weights before a touch tell which of an object's shapes is near the truth.
struct PriorScore {
  double log_likelihood = 0;  // mean over the objects, of a shape near the truth
  double unseen = 0;          // m, mean error of the likeliest shape
};

/// Of the cases with shapes. A shape is near the truth by exp(-(its error - the least) / 1 mm).
PriorScore score(const belief::ShapePrior& prior, const std::vector<BeliefCase>& cases);

/// The weights (ShapePrior's scales, methods, `lost`) that maximise the log likelihood, less a
/// small penalty for large ones: a softmax regression, by gradient ascent from the shipped ones.
belief::ShapePrior fitted_prior(const std::vector<BeliefCase>& cases);

/// What is fitted to all cases, beside what ships; and, of objects that it was not fitted to (by
/// turns a fifth of the data sets), how well both tell.
std::string prior_fit_text(const std::vector<BeliefCase>& cases);

}  // namespace prehend::eval
