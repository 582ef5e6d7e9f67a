#pragma once

#include <Eigen/Core>

#include "prehend/robot/hand_model.h"

namespace prehend::robot {

/// A jaw that slides closes like a finger of this length [m] that turns: so much for each radian.
inline constexpr double kJawLever = 0.1;

/// How the motors of a hand close round a thing [rad or m, of each motor]: what a planner predicts,
/// a cycle commands and a simulation executes. One number says how far they have closed [rad].
struct ClosingWay {
  Eigen::VectorXd open;          // before it closes
  Eigen::VectorXd closed;        // where its fingers are predicted to touch
  Eigen::VectorXd rate;          // signed, for each rad of closing; 0: stays
  Eigen::VectorXd lower, upper;  // limits of the joints

  /// Where closing is `beyond` [rad] past the predicted touch, each motor by its rate and no
  /// farther than its limit; before it (negative), and then at most back to where the hand is open.
  Eigen::VectorXd at(double beyond) const;
  /// How far the motors have closed, at these positions, past the predicted touch [rad]: the mean
  /// of those that close, each over its rate. 0 when none does.
  /// @pre positions.size() == closed.size()
  double closure(const Eigen::Ref<const Eigen::VectorXd>& positions) const;

  /// @throws std::invalid_argument when the sizes differ, something but a limit is not finite, or a
  /// lower limit is above its upper one.
  void validate() const;
};

/// Of a grasp by a preshape of `hand`, whose rates those of jaws take times kJawLever; `open` may
/// be empty: the preshape's.
ClosingWay closing_way(const HandModel& hand, const Preshape& preshape, const Eigen::VectorXd& open,
                       const Eigen::VectorXd& closed);

}  // namespace prehend::robot
