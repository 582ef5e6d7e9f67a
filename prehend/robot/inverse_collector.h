#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "prehend/robot/inverse_kinematics.h"

namespace prehend::robot {

/// Turns what was computed into answers.
struct InverseKinematics::Collector {
  const KinematicChain& chain;
  const Eigen::Ref<const Eigen::VectorXd>& seed;
  InverseAnswer answer{};
  int beyond = 0;            // solutions that the limits forbid
  Positions least_beyond{};  // the one that they forbid by the least
  double least = std::numeric_limits<double>::infinity();
  bool in_words = true;  // why there is none
  std::string unreachable{};
  double out_of_reach = 0;  // m
  InverseFailure failure = InverseFailure::kOutOfReach;

  /// Turns revolute joints by whole turns to within their limits; keeps what is.
  void add(Positions q) {
    double worst = 0;
    for (int i = 0; i < chain.size(); ++i) {
      const ChainJoint& joint = chain.joints()[static_cast<std::size_t>(i)];
      if (joint.is_revolute) {
        q[i] = seed[i] + std::remainder(q[i] - seed[i], 2 * std::numbers::pi);
        if (q[i] > joint.upper + 1e-9 && q[i] - 2 * std::numbers::pi >= joint.lower - 1e-9)
          q[i] -= 2 * std::numbers::pi;
        if (q[i] < joint.lower - 1e-9 && q[i] + 2 * std::numbers::pi <= joint.upper + 1e-9)
          q[i] += 2 * std::numbers::pi;
      }
      worst = std::max({worst, joint.lower - q[i], q[i] - joint.upper});
    }
    if (worst <= 1e-9) {
      answer.solutions.push_back(q);
      return;
    }
    ++beyond;
    if (worst < least) {
      least = worst;
      least_beyond = q;
    }
  }

  InverseAnswer finish() {
    std::stable_sort(answer.solutions.begin(), answer.solutions.end(),
                     [this](const Positions& a, const Positions& b) {
                       return (a - seed).squaredNorm() < (b - seed).squaredNorm();
                     });
    if (!answer.solutions.empty()) return std::move(answer);
    answer.failure = beyond > 0 ? InverseFailure::kBeyondLimits : failure;
    answer.miss = beyond > 0 ? least : out_of_reach;
    if (!in_words) return std::move(answer);
    if (beyond > 0) {
      answer.reason = std::to_string(beyond) +
                      " solutions are beyond the limits; in the nearest, " +
                      chain.limit_problem(least_beyond);
    } else {
      answer.reason = unreachable.empty() ? "out of reach" : unreachable;
    }
    return std::move(answer);
  }
};

}  // namespace prehend::robot
