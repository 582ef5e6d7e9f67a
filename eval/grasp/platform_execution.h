#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/grasp/world_under_test.h"
#include "prehend/control/attempt_watch.h"
#include "prehend/control/cycle_in_world.h"
#include "prehend/grasp/grasp.h"
#include "prehend/planning/platform_plan.h"

namespace prehend::eval {

/// What of the cycle an evaluation chooses.
struct ExecutionChoice {
  bool reacts = true;  // as control::ArmCycleOptions::reacts
  control::Task task = control::pick_and_place();
};

/// Executes a platform's plans by the shipped cycle (control::CycleInWorld), and watches the
/// object.
class PlatformExecution {
 public:
  /// The platform stands at `home` and outlives it. @throws as world_under_test().
  PlatformExecution(const robot::Platform& platform, const std::string& home,
                    const ExecutionChoice& choice, const TrueObject& truth);

  /// To the end of the cycle. @param plan_again on a new look after a failed attempt, when what was
  /// at p_W is at X_moved * p_W, with what that attempt found out.
  using PlanAgain = std::function<planning::PlatformPlan(const geometry::RigidTransform& X_moved,
                                                         const belief::Attempt& attempt)>;
  void run(const planning::PlatformPlan& plan, const PlanAgain& plan_again);

  /// What came of it: all of the trial but what its plan says. `lifted` is by 50 mm at least, put
  /// down, and said to be. @pre run()
  void record(GraspTrial* trial) const;

 private:
  geometry::RigidTransform moved() const;
  control::GraspsToTry to_try(const planning::PlatformPlan& plan);
  void watch();

  const robot::Platform& platform_;
  const TrueObject& truth_;
  std::unique_ptr<WorldUnderTest> world_;
  control::CycleInWorld cycle_;
  control::AttemptWatch attempt_watch_;
  ObjectReading start_;
  std::vector<grasp::Grasp> tried_;                                          // of the present plan
  std::optional<grasp::Grasp> grasp_;                                        // of the last attempt
  geometry::RigidTransform X_moved_ = geometry::RigidTransform::Identity();  // when that began
  std::optional<Eigen::Vector3d> p_HB_;  // m, when the lift began
  control::Phase phase_ = control::Phase::kWaiting;
  int attempts_ = 0;
  double raised_ = 0, slip_ = 0;  // m
  double first_robustness_ = kUnknown;
  std::string stage_, why_;  // of a first attempt that failed
};

}  // namespace prehend::eval
