#include "eval/belief/look_trial.h"

#include <optional>
#include <random>
#include <utility>

#include "eval/belief/belief_truth.h"
#include "eval/belief/predicted_case.h"
#include "eval/belief/rendered_hold.h"
#include "eval/grasp/in_reach.h"
#include "eval/processor_time.h"
#include "prehend/belief/attempt_memory.h"
#include "prehend/belief/held_object.h"
#include "prehend/geometry/errors.h"
#include "prehend/planning/camera_look.h"
#include "prehend/robot/placed_links.h"
#include "prehend/robot/robot_files.h"
#include "prehend/surface/model.h"
#include "prehend/text/tree_file.h"

namespace prehend::eval {
namespace {

using geometry::RigidTransform;

/// The looks of one robot at one case.
class LookTrial {
 public:
  LookTrial(const Case& one, const LookingRobot& robot, const LookTrialOptions& options)
      : one_(one),
        robot_(robot),
        platform_(robot.planner().platform()),
        options_(options),
        random_(one.seed),
        arm_(robot.start()),
        predicted_(predict_case(one)),
        model_(surface::make_object_model(predicted_.shape, predicted_.support_W)),
        truth_(one, predicted_.viewpoint_W) {}

  void run(BeliefCase* result) {
    if (truth_.is_all_seen()) {
      throw geometry::InputError("All of it was seen", "Look from elsewhere");
    }
    BeliefSeries prediction{kPredictionSeries, "", {}};
    add_step(0, kUnknown, model_.mesh_W, &prediction);
    result->series.push_back(prediction);
    if (is_carried()) {
      look_from_elsewhere(result);
    } else {
      look_in_hand(result);
    }
  }

 private:
  bool is_carried() const { return platform_.X_FC.has_value(); }

  void add_step(int looks, double seconds, const geometry::TriangleMesh& mesh_W,
                BeliefSeries* series) const {
    BeliefStep step;
    step.touches = looks;
    step.seconds = seconds;
    truth_.measure(mesh_W, one_.seed, &step);
    series->steps.push_back(step);
  }

  /// Where something is said to be that is known up to the trial's placement and orientation.
  RigidTransform said(const RigidTransform& X) {
    return disturbance(options_.placement, options_.orientation, X.translation(), &random_) * X;
  }

  PredictedCase seen_from(const robot::Positions& arm, int look) {
    const RigidTransform X_WC = platform_.X_WC(arm);
    const robot::HandModel& hand = platform_.hand;
    const Eigen::VectorXd open = hand.all_positions(hand.preshapes.front().open);
    return predict_case(
        one_, CarriedView{X_WC, said(X_WC), robot::placed_links(platform_, arm, open), look});
  }

  void look_from_elsewhere(BeliefCase* result) {
    BeliefSeries together{"looks from elsewhere", "", {}}, alone{"the last look alone", "", {}};
    add_step(0, kUnknown, model_.mesh_W, &together);
    add_step(0, kUnknown, model_.mesh_W, &alone);
    belief::AttemptMemory memory(platform_.hand);
    const geometry::StereoCamera camera = scene_of(one_).scene.camera.camera;
    for (int look = 1; look <= options_.looks; ++look) {
      const planning::PlannedLook planned = planning::plan_look(
          platform_, arm_, camera, model_, {predicted_.support_W, model_.convex_pieces_W, {}}, {},
          {.budget = 0});
      if (!planned.found()) {
        together.problem = planned.problem;
        break;
      }
      memory.add_look(predicted_.shape, predicted_.support_W, model_.mesh_W);
      arm_ = planned.way.back();
      try {
        predicted_ = seen_from(arm_, look);
      } catch (const geometry::InputError& error) {
        together.problem = error.what();
        break;
      }
      const double start = processor_time();
      std::optional<belief::Recollection> known =
          memory.recall(predicted_.shape, predicted_.support_W);
      const double seconds = processor_time() - start;
      surface::ObjectModel fresh =
          surface::make_object_model(predicted_.shape, predicted_.support_W);
      add_step(look, kUnknown, fresh.mesh_W, &alone);
      if (!known && together.problem.empty()) together.problem = memory.problem();
      model_ = known ? std::move(known->model) : std::move(fresh);
      add_step(look, seconds, model_.mesh_W, &together);
    }
    result->series.push_back(together);
    result->series.push_back(alone);
  }

  void look_in_hand(BeliefCase* result) {
    const RenderedScene rendered = scene_of(one_);
    const geometry::PinholeCamera& camera = rendered.scene.camera.camera.left;
    const RigidTransform X_WC = rendered.scene.camera.X_WC();
    planning::PlatformPlanOptions planning(platform_.hand);
    planning.grasps.threads = 1;
    planning.motions = 1;
    planning.viewing = planning::ViewingCamera{camera, X_WC};
    planning.views.views = options_.looks;
    planning.views.budget = 0;
    const planning::PlatformPlan plan =
        robot_.planner().plan(model_, predicted_.support_W, {}, {}, arm_, planning);
    if (plan.picks.empty() || plan.picks.front().segments.empty()) {
      throw geometry::InputError("It cannot be grasped: " + plan.problem, "Take another hand");
    }
    const planning::PlannedPick& pick = plan.picks.front();
    BeliefSeries series{"looks in the hand", "", {}};
    if (pick.views.views.empty()) series.problem = pick.views.problem;
    const robot::KinematicChain chain = platform_.arm_chain();
    const RigidTransform slipped =
        disturbance(options_.slip, options_.turn, truth_.query().box().center(), &random_);
    belief::HeldObject held(predicted_.shape, predicted_.support_W);
    add_step(0, kUnknown, held.model().mesh_W, &series);
    int looks = 0;
    for (const planning::HeldView& view : pick.views.views) {
      const robot::Positions& arm = view.way.back();
      const RigidTransform X_WH = platform_.X_WB * chain.forward(arm) * platform_.X_FH;
      const RigidTransform X_moved = X_WH * pick.grasp.X_WH.inverse();
      const std::vector<geometry::TriangleMesh> links_W =
          robot::placed_links(platform_, arm, pick.grasp.closed_all);
      const geometry::DepthImage depth = seen_hold(
          rendered, one_.data_set->mesh_B, X_moved * slipped * one_.X_WB(), links_W, ++looks);
      const double start = processor_time();
      const RigidTransform X_said = said(X_WH) * X_WH.inverse(Eigen::Isometry);
      std::vector<geometry::TriangleMesh> said_links_W;
      for (const auto& link : links_W) {
        said_links_W.push_back(geometry::transformed(link, X_said));
      }
      const RigidTransform X_WO = X_said * X_moved;
      const geometry::PointCloud thought_W = geometry::transformed(predicted_.shape.cloud_W, X_WO);
      belief::HeldLook look = belief::held_look(depth, camera, X_WC, {}, said_links_W, thought_W);
      look.X_WO = X_WO;
      const belief::TakenLook taken = held.add(look);
      if (!taken.problem.empty() && series.problem.empty()) series.problem = taken.problem;
      const geometry::TriangleMesh mesh_W = held.model().mesh_W;
      add_step(looks, processor_time() - start, mesh_W, &series);
    }
    result->series.push_back(series);
  }

  const Case& one_;
  const LookingRobot& robot_;
  const robot::Platform& platform_;
  LookTrialOptions options_;
  std::mt19937_64 random_;
  robot::Positions arm_;
  PredictedCase predicted_;
  surface::ObjectModel model_;  // what is believed
  BeliefTruth truth_;
};

}  // namespace

LookingRobot::LookingRobot(const std::string& name)
    : planner_(in_reach(
          robot::read_platform(robot::platform_file(text::tree_file("config/robots"), name)))) {}

robot::Positions LookingRobot::start() const { return planner_.platform().home("home").arm; }

BeliefCase run_look_trial(const Case& one, const LookingRobot& robot,
                          const LookTrialOptions& options) {
  BeliefCase result = belief_case_of(one);
  try {
    LookTrial(one, robot, options).run(&result);
  } catch (const std::exception& error) {
    result.problem = error.what();
  }
  return result;
}

}  // namespace prehend::eval
