#include "eval/grasp/parallel_gripper.h"

#include <algorithm>
#include <exception>
#include <string>

#include "eval/grasp/grasp_execution.h"
#include "eval/processor_time.h"
#include "prehend/grasp/closing/close_pads.h"
#include "prehend/simulation/world.h"

namespace prehend::eval {
namespace {

constexpr double kLeastLift = 0.1;  // m
constexpr double kTimeLimit = 180;  // s, simulated, of three attempts

/// Contact area of the grasp closed on the object [m^2], mean of both pads; NaN where it would not
/// close on it.
double area_on(const geometry::MeshQuery& object_W, const grasp::Grasp& grasp,
               const robot::GripperModel& gripper) {
  const grasp::ClosedHand hand =
      grasp::close_hand(object_W, grasp.X_WG, grasp::pregrasp_opening(grasp), grasp.force, gripper);
  return hand.outcome == grasp::ClosingOutcome::kClosed ? 0.5 * (hand.left.area + hand.right.area)
                                                        : kUnknown;
}

GraspTrial try_gripper(const Belief& believed, const TrueObject& truth,
                       const PlannerSetting& setting, const BelieveAgain& believe_again) {
  simulation::Scene scene;
  grasp::Reachability reachability;
  reachability.approach_W = -Eigen::Vector3d::UnitZ();
  reachability.workspace_W = {scene.carrier.minimum, scene.carrier.maximum};
  GraspTrial trial;
  const double start = processor_time();
  const robot::HandModel hand = robot::parallel_hand(scene.gripper);
  const grasp::HandToClose to_close(hand);
  const grasp::PlannerOptions options = options_for(hand, setting);
  const auto plan_on = [&](const Belief& belief) {
    return grasp::plan_grasps(belief.object, geometry::Plane{}, belief.obstacles, to_close,
                              reachability, options);
  };
  const auto plan = plan_on(believed);
  trial.plan_seconds = processor_time() - start;
  trial.candidates = plan.candidates;
  trial.grasps = static_cast<int>(plan.grasps.size());
  trial.problem = grasp::in_words(plan);
  for (const auto& grasp : plan.grasps) {
    trial.best_robustness = std::max(trial.best_robustness, grasp.robustness);
  }
  if (plan.grasps.empty()) return trial;

  simulation::World world(scene);
  world.add_object("object", truth.mesh_W, truth.mass);
  for (const geometry::TriangleMesh& other_W : truth.others_W) {
    world.add_object("other " + std::to_string(world.body_count()), other_W, truth.mass, true);
  }
  const GraspExecution execution =
      execute_grasps(world, 0, plan, kTimeLimit, [&](const geometry::RigidTransform& X_moved) {
        try {
          return plan_on(believe_again(X_moved));
        } catch (const std::exception& error) {
          grasp::GraspPlan none;
          none.problem = error.what();
          return none;
        }
      });
  trial.lifted = execution.result.success() && execution.raised >= kLeastLift;
  trial.attempts = execution.result.attempts;
  trial.outcome = execution.result.reason;
  trial.slip = execution.slip;
  trial.plans = execution.result.plans;
  const grasp::Grasp& grasp = execution.grasp;
  const geometry::MeshQuery truth_W(geometry::transformed(truth.mesh_W, execution.X_moved));
  trial.contact_error = mean_distance(grasp::contact_points(grasp), truth_W);
  if (trial.attempts > 0)
    trial.area_error = grasp.predicted.contact_area / area_on(truth_W, grasp, scene.gripper) - 1;
  trial.robustness = grasp.robustness;
  trial.guessed_contact = grasp.guessed_contact;
  trial.surprises = execution.surprises;
  for (const auto& surprise : execution.surprises) {
    if (surprise.kind == control::SurpriseKind::kOpeningAtContact) {
      trial.opening_error = surprise.felt - surprise.predicted;
    }
  }
  return trial;
}

}  // namespace

HandUnderTest parallel_gripper() { return {"pg70", try_gripper}; }

}  // namespace prehend::eval
