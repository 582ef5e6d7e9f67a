#include "eval/belief/look_trial.h"

#include <random>
#include <utility>

#include "eval/belief/belief_truth.h"
#include "eval/belief/predicted_case.h"
#include "eval/belief/rendered_hold.h"
#include "eval/grasp/in_reach.h"
#include "eval/processor_time.h"
#include "prehend/belief/held_object.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/placed_links.h"
#include "prehend/robot/robot_files.h"
#include "prehend/surface/model.h"
#include "prehend/text/tree_file.h"

namespace prehend::eval {

using geometry::RigidTransform;

TurningRobot::TurningRobot(const std::string& name)
    : planner_(in_reach(
          robot::read_platform(robot::platform_file(text::tree_file("config/robots"), name)))) {}

robot::Positions TurningRobot::start() const { return planner_.platform().home("home").arm; }

BeliefCase run_look_trial(const Case& one, const TurningRobot& robot,
                          const LookTrialOptions& options) {
  BeliefCase result = belief_case_of(one);
  try {
    const PredictedCase predicted = predict_case(one);
    const BeliefTruth truth(one, predicted.viewpoint_W);
    if (truth.is_all_seen()) {
      throw geometry::InputError("All of it was seen", "Look from elsewhere");
    }
    const surface::ObjectModel model =
        surface::make_object_model(predicted.shape, predicted.support_W);
    BeliefSeries prediction{kPredictionSeries, "", {{}}};
    truth.measure(model.mesh_W, one.seed, &prediction.steps.front());
    result.series.push_back(prediction);

    const RenderedScene rendered = scene_of(one);
    const robot::Platform& platform = robot.planner().platform();
    planning::PlatformPlanOptions planning(platform.hand);
    planning.grasps.threads = 1;
    planning.motions = 1;
    planning.viewing =
        planning::ViewingCamera{rendered.scene.camera.camera.left, rendered.scene.camera.X_WC()};
    planning.views.views = options.looks;
    planning.views.budget = 0;
    const planning::PlatformPlan plan =
        robot.planner().plan(model, predicted.support_W, {}, {}, robot.start(), planning);
    if (plan.picks.empty() || plan.picks.front().segments.empty()) {
      throw geometry::InputError("It cannot be grasped: " + plan.problem, "Take another hand");
    }
    const planning::PlannedPick& pick = plan.picks.front();
    BeliefSeries series{"looks in the hand", "", {}};
    if (pick.views.views.empty()) series.problem = pick.views.problem;
    const robot::KinematicChain chain = platform.arm_chain();
    std::mt19937_64 random(one.seed);
    const Eigen::Vector3d middle = truth.query().box().center();
    const RigidTransform slipped = disturbance(options.slip, options.turn, middle, &random);
    belief::HeldObject held(predicted.shape, predicted.support_W);
    const auto add_step = [&](int looks, double seconds, const geometry::TriangleMesh& mesh) {
      BeliefStep step;
      step.touches = looks;
      step.seconds = seconds;
      truth.measure(mesh, one.seed, &step);
      series.steps.push_back(step);
    };
    add_step(0, kUnknown, held.model().mesh_W);
    int looks = 0;
    for (const planning::HeldView& view : pick.views.views) {
      const robot::Positions& arm = view.way.back();
      const RigidTransform X_WH = platform.X_WB * chain.forward(arm) * platform.X_FH;
      const RigidTransform X_moved = X_WH * pick.grasp.X_WH.inverse();
      const geometry::DepthImage depth =
          seen_hold(rendered, one.data_set->mesh_B, X_moved * slipped * one.X_WB(),
                    robot::placed_links(platform, arm, pick.grasp.closed_all), ++looks);
      const double start = processor_time();
      const RigidTransform said =
          disturbance(options.placement, options.orientation, X_WH.translation(), &random);
      std::vector<geometry::TriangleMesh> links_W;
      for (const auto& link : robot::placed_links(platform, arm, pick.grasp.closed_all)) {
        links_W.push_back(geometry::transformed(link, said));
      }
      const RigidTransform X_WO = said * X_moved;
      const geometry::PointCloud thought_W = geometry::transformed(predicted.shape.cloud_W, X_WO);
      belief::HeldLook look =
          belief::held_look(depth, rendered.scene.camera.camera.left, rendered.scene.camera.X_WC(),
                            {}, links_W, thought_W);
      look.X_WO = X_WO;
      const belief::TakenLook taken = held.add(look);
      if (!taken.problem.empty() && series.problem.empty()) series.problem = taken.problem;
      const geometry::TriangleMesh mesh = held.model().mesh_W;
      add_step(looks, processor_time() - start, mesh);
    }
    result.series.push_back(series);
  } catch (const std::exception& error) {
    result.problem = error.what();
  }
  return result;
}

}  // namespace prehend::eval
