#pragma once

#include <filesystem>
#include <string>

#include "eval/grasp/platform_execution.h"
#include "eval/grasp/trial_setup.h"
#include "prehend/planning/platform_plan.h"

namespace prehend::eval {

/// An arm and its hand as they ship: plans with the arm's motion (planning::PlatformPlanner),
/// executes with the cycle (PlatformExecution), and looks again after a failed attempt. The arm
/// starts from its home `side`, else `home`; the platform is in_reach(). Planning takes one thread:
/// processes share the cores, and times are of one.
class PlatformUnderTest {
 public:
  /// @throws geometry::InputError as robot::read_platform(), in_reach() and, of a gripper that is
  /// moved by its drive, simulation::carrier_of().
  explicit PlatformUnderTest(const std::filesystem::path& file, ExecutionChoice choice = {});

  const std::string& name() const { return planner_.platform().name; }
  const robot::HandModel& hand() const { return planner_.platform().hand; }

  /// Plans on what is believed by `setting`, executes on what is there.
  GraspTrial grasp(const Belief& believed, const TrueObject& truth, const PlannerSetting& setting,
                   const BelieveAgain& believe_again) const;

 private:
  planning::PlatformPlan plan(const Belief& belief, const PlannerSetting& setting) const;

  planning::PlatformPlanner planner_;
  ExecutionChoice choice_;
  std::string home_;
};

}  // namespace prehend::eval
