#pragma once

#include <memory>
#include <string>
#include <vector>

#include "eval/motion/motion_problem.h"
#include "eval/motion/path_oracle.h"
#include "eval/motion/planning_robot.h"
#include "prehend/motion/path_planner.h"
#include "prehend/motion/robot_in_world.h"
#include "prehend/motion/robot_shapes.h"

namespace prehend::eval {

/// What a planner made of a problem.
struct MotionResult {
  std::string planner, set, name;
  bool solved = false;
  std::string reason;   // why not
  std::string invalid;  // where the path is not free by the oracle; empty: it is, or there is none
  double set_up = 0;    // s of this thread's processor time: robot and obstacles laid out
  double time = 0;      // s of it: planning and shortening
  double length = 0;    // rad, in joint space
  int iterations = 0;
};

struct MotionTrialOptions {
  motion::PathOptions path;
  /// m; the next where one does not lead to a path. Finer ones take longer to set up and to test.
  std::vector<double> ball_resolutions{0.06, 0.03, 0.015};
  /// Of motion::CheckerRegistry, which test the links' own shapes, each where those before it did
  /// not lead to a path.
  std::vector<std::string> checkers{"fcl"};
  double check_step = 1.0 / 512;  // rad or m, of the oracle
};

/// A robot's problems, one after the other.
class MotionTrials {
 public:
  MotionTrials(const PlanningRobot& robot, const MotionTrialOptions& options);

  /// What the oracle finds wrong with start or goal; empty: they are free.
  std::string invalid_problem(const MotionProblem& problem);
  MotionResult run(const MotionProblem& problem, const motion::PathPlanner& planner);

 private:
  robot::Positions positions_of(const std::map<std::string, double>& by_name) const;

  PlanningRobot robot_;
  MotionTrialOptions options_;
  robot::KinematicChain chain_;
  std::vector<motion::RobotSpheres> spheres_;  // of each resolution
  std::vector<motion::RobotShape> shapes_;
  std::vector<std::shared_ptr<const motion::CollisionChecker>> checkers_;
  PathOracle oracle_;
};

}  // namespace prehend::eval
