#pragma once

#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prehend/touch/grasp_stability.h"

namespace prehend::eval {

/// A question whose answer is known.
struct KnownHold {
  Eigen::VectorXd features;  // touch::grip_features()
  bool held = false;
  std::string object;  // its name: standing and lying is the same object
  std::string hand;
};

/// The logistic regression of touch::GraspStability that makes the answers likeliest, with
/// `ridge` / 2 times the sum of the squared weights as prior (Ceres, L-BFGS). Of features that do
/// not differ the weight is 0. @throws std::invalid_argument unless some held and some did not.
touch::GraspStability::Weighed fit_stability(const std::vector<KnownHold>& known, double ridge = 2);

/// The probability of each by a model of the other objects: they are dealt to `folds` in the order
/// of their names, and each fold's are answered by a model of those of the others. @param per_hand
/// a model of each hand. NaN where a model could not be made.
std::vector<double> crossed_probabilities(const std::vector<KnownHold>& known, int folds,
                                          bool per_hand = false);

/// A probability and whether it held.
using Answer = std::pair<double, bool>;

/// Share of those that held (y) over share of those that did not (x) that are at least as probable
/// as a bound, for every bound, from (0, 0) to (1, 1).
std::vector<std::pair<double, double>> roc_curve(std::vector<Answer> answers);
/// Its area: how often one that held is more probable than one that did not, ties half.
/// NaN unless there are both.
double roc_area(const std::vector<Answer>& answers);

struct AreaBounds {
  double low = 0, high = 0;
};
/// 95 % of the areas when objects are drawn anew with replacement (bootstrap, 1000 times, fixed
/// seed): grasps of an object are not independent of one another.
AreaBounds area_bounds(const std::vector<Answer>& answers, const std::vector<std::string>& objects);

}  // namespace prehend::eval
