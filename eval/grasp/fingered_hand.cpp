#include "eval/grasp/fingered_hand.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "eval/processor_time.h"
#include "prehend/simulation/hand_grasp.h"

namespace prehend::eval {
namespace {

constexpr int kAttempts = 3;

// Refers to itself.
struct Hand {
  Hand(const std::filesystem::path& robots, const std::string& name)
      : model(robot::read_hand_model(robots / (name + ".yaml"))), to_close(model) {}
  Hand(const Hand&) = delete;
  Hand& operator=(const Hand&) = delete;
  const robot::HandModel model;
  const grasp::HandToClose to_close;
};

void record_plan(const grasp::GraspPlan& plan, GraspTrial* trial) {
  trial->candidates = plan.candidates;
  trial->grasps = static_cast<int>(plan.grasps.size());
  trial->problem = grasp::in_words(plan);
  for (const auto& grasp : plan.grasps) {
    trial->best_robustness = std::max(trial->best_robustness, grasp.robustness);
  }
}

GraspTrial try_hand(const Hand& hand, const Belief& believed, const TrueObject& truth,
                    const PlannerSetting& setting) {
  GraspTrial trial;
  const double start = processor_time();
  const grasp::GraspPlan plan =
      grasp::plan_grasps(believed.object, geometry::Plane{}, believed.obstacles, hand.to_close, {},
                         options_for(hand.model, setting));
  trial.plan_seconds = processor_time() - start;
  record_plan(plan, &trial);
  simulation::HandGraspOptions execution;
  execution.mass = truth.mass;
  const int attempts = std::min(kAttempts, trial.grasps);
  while (!trial.lifted && trial.attempts < attempts) {
    const grasp::Grasp& grasp = plan.grasps[static_cast<std::size_t>(trial.attempts++)];
    const std::vector<Eigen::Vector3d> contacts = grasp::contact_points(grasp);
    const auto outcome =
        simulation::execute_hand_grasp(hand.model,
                                       {grasp.X_WG, grasp.preshape, grasp.open, grasp.closed,
                                        grasp.approach_W, grasp.pregrasp_distance, contacts},
                                       truth.mesh_W, execution, truth.others_W);
    trial.lifted = outcome.held;
    if (trial.attempts == 1) trial.outcome = outcome.reason;
    trial.slip = outcome.slip;
    trial.contact_error = mean_distance(contacts, geometry::MeshQuery(truth.mesh_W));
    trial.robustness = grasp.robustness;
    trial.guessed_contact = grasp.guessed_contact;
  }
  return trial;
}

}  // namespace

HandUnderTest fingered_hand(const std::filesystem::path& robots, const std::string& name) {
  const auto hand = std::make_shared<const Hand>(robots, name);
  return {name,
          [hand](const Belief& believed, const TrueObject& truth, const PlannerSetting& setting,
                 const BelieveAgain&) { return try_hand(*hand, believed, truth, setting); }};
}

}  // namespace prehend::eval
