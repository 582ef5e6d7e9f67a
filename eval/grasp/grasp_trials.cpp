#include "eval/grasp/grasp_trials.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <exception>
#include <optional>
#include <utility>

#include "eval/case_runner.h"
#include "eval/grasp/grasp_execution.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/shape/symmetry.h"
#include "prehend/surface/delaunay.h"
#include "prehend/surface/model.h"

namespace prehend::eval {
namespace {

constexpr double kLeastLift = 0.1;  // m

double processor_time() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// kg, of a household thing of that volume [m^3].
double household_mass(double volume) { return std::clamp(400 * volume, 0.02, 0.6); }

double mean_distance(const std::vector<Eigen::Vector3d>& left,
                     const std::vector<Eigen::Vector3d>& right, const geometry::MeshQuery& truth) {
  double sum = 0;
  for (const auto* points : {&left, &right}) {
    for (const auto& p : *points) sum += truth.nearest(p)->distance;
  }
  return sum / static_cast<double>(left.size() + right.size());
}

GraspTrial try_gripper(const surface::ObjectModel& believed, const TrueObject& truth,
                       const PlannerSetting& setting) {
  simulation::Scene scene;
  grasp::Reachability reachability;
  reachability.approach_W = -Eigen::Vector3d::UnitZ();
  reachability.workspace_W = {scene.carrier.minimum, scene.carrier.maximum};
  GraspTrial trial;
  const double start = processor_time();
  const auto plan = grasp::plan_grasps(believed, geometry::Plane{}, {}, scene.gripper, reachability,
                                       setting.options);
  trial.plan_seconds = processor_time() - start;
  trial.candidates = plan.candidates;
  trial.grasps = static_cast<int>(plan.grasps.size());
  trial.problem = plan.problem;
  for (const auto& grasp : plan.grasps) {
    trial.best_robustness = std::max(trial.best_robustness, grasp.robustness);
  }
  if (plan.grasps.empty()) return trial;

  simulation::World world(scene);
  world.add_object("object", truth.mesh_W, truth.mass);
  const GraspExecution execution = execute_grasps(world, 0, plan);
  trial.lifted = execution.result.success && execution.raised >= kLeastLift;
  trial.attempts = execution.result.attempts;
  trial.outcome = execution.result.reason;
  trial.slip = execution.slip;
  const grasp::Grasp& grasp = plan.grasps[execution.result.grasp_index];
  trial.contact_error = mean_distance(grasp.left_contacts_W, grasp.right_contacts_W,
                                      geometry::MeshQuery(truth.mesh_W));
  trial.robustness = grasp.robustness;
  trial.guessed_contact = grasp.guessed_contact;
  for (const auto& surprise : execution.surprises) {
    if (surprise.kind == control::SurpriseKind::kOpeningAtContact) {
      trial.opening_error = surprise.felt - surprise.predicted;
    }
  }
  return trial;
}

}  // namespace

std::vector<PlannerSetting> compared_settings() {
  std::vector<PlannerSetting> settings;
  for (const PlannedOn on : {PlannedOn::kPredicted, PlannedOn::kTruth, PlannedOn::kDelaunay}) {
    settings.push_back({to_string(on), on, {}});
    // The truth is not wider than the object.
    if (on == PlannedOn::kTruth) settings.back().options.width_tolerance = 0;
  }
  return settings;
}

HandUnderTest parallel_gripper() { return {"pg70", try_gripper}; }

GraspCase run_grasp_case(const Case& one, const HandUnderTest& hand,
                         const std::vector<PlannerSetting>& settings) {
  GraspCase result;
  result.case_name = one.name();
  result.group = one.data_set->group;
  result.data_set = one.data_set->name;
  result.orientation = one.orientation;
  result.hand = hand.name;

  const TrueObject truth{geometry::transformed(*one.data_set->mesh_B, one.X_WB()),
                         household_mass(geometry::mass_properties(*one.data_set->mesh_B).volume)};
  std::optional<surface::ObjectModel> predicted;
  surface::ObjectModel delaunay, known;
  known.mesh_W = truth.mesh_W;
  std::string predicted_problem, delaunay_problem;
  try {
    const RenderedScene rendered = scene_of(one);
    simulation::RenderOptions render;
    render.threads = 1;
    const auto images = simulation::render_stereo(rendered.scene, rendered.bodies, 0, render);
    const perception::SegmentedScene scene = seen_scene(rendered, images);
    const std::optional<std::size_t> object = object_of(scene, images.labels);
    if (!object) {
      result.problem = "The object was not found on the table";
    } else {
      const perception::ObjectHypothesis& seen = scene.objects[*object];
      const double start = processor_time();
      try {
        const shape::CompletedShape shape = shape::complete_by_symmetry(
            {seen.cloud_W, seen.mask, scene.camera, scene.X_WC, scene.table_W});
        predicted = surface::make_object_model(shape, scene.table_W);
      } catch (const std::exception& error) {
        predicted_problem = error.what();
      }
      result.predict_seconds = processor_time() - start;
      try {
        delaunay.mesh_W = surface::delaunay_surface(seen.cloud_W, scene.camera, scene.X_WC);
      } catch (const std::exception& error) {
        delaunay_problem = error.what();
      }
    }
  } catch (const std::exception& error) {
    result.problem = error.what();
  }
  for (const PlannerSetting& setting : settings) {
    GraspTrial trial;
    try {
      const bool from_view = setting.planned_on != PlannedOn::kTruth;
      if (from_view && !result.problem.empty()) {
        trial.problem = result.problem;
      } else if (setting.planned_on == PlannedOn::kPredicted && !predicted) {
        trial.problem = predicted_problem;
      } else if (setting.planned_on == PlannedOn::kDelaunay && !delaunay_problem.empty()) {
        trial.problem = delaunay_problem;
      } else {
        const surface::ObjectModel& believed =
            setting.planned_on == PlannedOn::kPredicted  ? *predicted
            : setting.planned_on == PlannedOn::kDelaunay ? delaunay
                                                         : known;
        trial = hand.grasp(believed, truth, setting);
      }
    } catch (const std::exception& error) {
      trial.problem = error.what();
    }
    trial.setting = setting.name;
    result.trials.push_back(std::move(trial));
  }
  return result;
}

}  // namespace prehend::eval
