#pragma once

#include <string>

#include "eval/belief/touch_trial.h"
#include "eval/data_sets.h"
#include "prehend/planning/platform_plan.h"

namespace prehend::eval {

/// An arm that turns what its hand holds before the camera.
class TurningRobot {
 public:
  /// @param name of a platform of config/robots. @throws geometry::InputError with the nearest
  /// name.
  explicit TurningRobot(const std::string& name);

  const planning::PlatformPlanner& planner() const { return planner_; }
  robot::Positions start() const;

 private:
  planning::PlatformPlanner planner_;
};

struct LookTrialOptions {
  int looks = 4;               // in the hand, at most
  double slip = 0.003;         // m, standard, in each direction, that closing moves it in the hand
  double turn = 0.05;          // rad, standard, about each axis, the same
  double placement = 0.0005;   // m, standard, of where the hand is said to be at each look
  double orientation = 0.002;  // rad, the same
};

/// Renders the case's view, predicts the object, plans a grasp and the views of what is held as
/// nodes do, and renders it at each of them in the closed hand of the arm, with other slips in the
/// hand than the planner knows of. One series: what the looks make of the prediction.
BeliefCase run_look_trial(const Case& one, const TurningRobot& robot,
                          const LookTrialOptions& options = {});

}  // namespace prehend::eval
