#pragma once

#include <string>

#include "eval/belief/touch_trial.h"
#include "eval/data_sets.h"
#include "prehend/planning/platform_plan.h"

namespace prehend::eval {

/// An arm that turns what its hand holds before the camera, or that carries the camera.
class LookingRobot {
 public:
  /// @param name of a platform of config/robots. @throws geometry::InputError with the nearest
  /// name.
  explicit LookingRobot(const std::string& name);

  const planning::PlatformPlanner& planner() const { return planner_; }
  robot::Positions start() const;

 private:
  planning::PlatformPlanner planner_;
};

struct LookTrialOptions {
  int looks = 4;               // after the first one, at most
  double slip = 0.003;         // m, standard, in each direction, that closing moves it in the hand
  double turn = 0.05;          // rad, standard, about each axis, the same
  double placement = 0.0005;   // m, standard, of where hand or camera is said to be at each look
  double orientation = 0.002;  // rad, the same
};

/// Renders the case's view, predicts the object, plans looks as nodes do, renders what they show,
/// and measures what they make of the prediction.
///
/// An arm that carries a camera looks from elsewhere: one series of what the looks show together
/// with the case's view, and one of what the last one shows by itself. Any other arm grasps the
/// object and turns it before the camera, with other slips in the hand than the planner knows of:
/// one series.
BeliefCase run_look_trial(const Case& one, const LookingRobot& robot,
                          const LookTrialOptions& options = {});

}  // namespace prehend::eval
