#include "eval/grasp/platform_under_test.h"

#include <algorithm>
#include <chrono>
#include <exception>

#include "eval/grasp/in_reach.h"
#include "eval/grasp/platform_execution.h"
#include "eval/processor_time.h"
#include "prehend/simulation/stage_arm.h"
#include "prehend/surface/object_model.h"

namespace prehend::eval {
namespace {

// As launch files have it: out of the camera's view.
std::string start_of(const robot::Platform& platform) {
  const auto& homes = platform.homes;
  const bool has_side =
      std::any_of(homes.begin(), homes.end(), [](const auto& one) { return one.name == "side"; });
  return has_side ? "side" : "home";
}

}  // namespace

PlatformUnderTest::PlatformUnderTest(const std::filesystem::path& file, ExecutionChoice choice)
    : planner_(in_reach(robot::read_platform(file))),
      choice_(std::move(choice)),
      home_(start_of(planner_.platform())) {
  if (planner_.platform().hand_port == robot::HandPort::kGripper) {
    simulation::carrier_of(planner_.platform(), home_);
  }
}

planning::PlatformPlan PlatformUnderTest::plan(const Belief& belief,
                                               const PlannerSetting& setting) const {
  const robot::Platform& platform = planner_.platform();
  planning::PlatformPlanOptions options(platform.hand);
  options.touch.emplace().threads = 1;
  if (belief.shape) {
    options.shape_confidence =
        surface::mesh_confidence(belief.shape->confidence, belief.object.substitute);
  }
  if (setting.change) setting.change(&options);
  options.grasps.threads = 1;
  return planner_.plan(belief.object, {}, belief.others, {}, platform.home(home_).arm, options);
}

GraspTrial PlatformUnderTest::grasp(const Belief& believed, const TrueObject& truth,
                                    const PlannerSetting& setting,
                                    const BelieveAgain& believe_again) const {
  GraspTrial trial;
  const double start = processor_time();
  const auto begin = std::chrono::steady_clock::now();
  const planning::PlatformPlan first = plan(believed, setting);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  trial.plan_seconds = processor_time() - start;
  // Other programs slow all parts alike.
  trial.grasp_seconds = trial.plan_seconds * first.grasp_time / took.count();
  trial.candidates = first.candidates;
  trial.grasps = static_cast<int>(first.picks.size());
  trial.problem = grasp::in_words(first);
  trial.best_robustness = std::max(0.0, first.robustness);
  trial.is_planned_only = !setting.is_executed;
  if (trial.is_planned_only) return trial;
  if (first.picks.empty()) {
    trial.stage = first.arm_rejections.empty() ? "plan" : "arm";
    return trial;
  }
  PlatformExecution execution(planner_.platform(), home_, choice_, truth);
  execution.run(first,
                [&](const geometry::RigidTransform& X_moved, const belief::Attempt& attempt) {
                  try {
                    return plan(believe_again(X_moved, attempt), setting);
                  } catch (const std::exception& error) {
                    planning::PlatformPlan none;
                    none.problem = error.what();
                    return none;
                  }
                });
  execution.record(&trial);
  return trial;
}

}  // namespace prehend::eval
