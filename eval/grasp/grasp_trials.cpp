#include "eval/grasp/grasp_trials.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <utility>

#include "eval/case_runner.h"
#include "eval/grasp/resting_pose.h"
#include "eval/processor_time.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/shape/symmetry.h"
#include "prehend/surface/delaunay.h"
#include "prehend/surface/model.h"

namespace prehend::eval {
namespace {

// kg, of a household thing of that volume [m^3].
double household_mass(double volume) { return std::clamp(400 * volume, 0.02, 0.6); }

}  // namespace

std::vector<PlannerSetting> compared_settings() {
  std::vector<PlannerSetting> settings;
  for (const PlannedOn on : {PlannedOn::kPredicted, PlannedOn::kTruth, PlannedOn::kDelaunay}) {
    settings.push_back({to_string(on), on, {}, {}});
    // The truth is not wider than the object.
    if (on == PlannedOn::kTruth) settings.back().options.width_tolerance = 0;
  }
  return settings;
}

GraspCase run_grasp_case(const Case& one, const HandUnderTest& hand,
                         const std::vector<PlannerSetting>& settings) {
  GraspCase result;
  result.case_name = one.name();
  result.group = one.data_set->group;
  result.data_set = one.data_set->name;
  result.orientation = one.orientation;
  result.hand = hand.name;

  const geometry::TriangleMesh& mesh_B = *one.data_set->mesh_B;
  const double mass = household_mass(geometry::mass_properties(mesh_B).volume);
  const geometry::RigidTransform X_WB = resting_pose(mesh_B, one.X_WB(), mass);
  const TrueObject truth{geometry::transformed(mesh_B, X_WB), mass};
  std::optional<surface::ObjectModel> predicted;
  surface::ObjectModel delaunay, known;
  known.mesh_W = truth.mesh_W;
  std::string predicted_problem, delaunay_problem;
  try {
    RenderedScene rendered = scene_of(one);
    rendered.bodies.front().X_WB = X_WB;
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
