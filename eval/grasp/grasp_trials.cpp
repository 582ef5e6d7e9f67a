#include "eval/grasp/grasp_trials.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <optional>
#include <utility>

#include "eval/grasp/seen_object.h"
#include "eval/household_objects.h"
#include "eval/processor_time.h"
#include "eval/resting_pose.h"
#include "prehend/geometry/errors.h"

namespace prehend::eval {
std::vector<PlannerSetting> compared_settings(const std::vector<std::string>& executed) {
  std::vector<PlannerSetting> settings;
  for (const PlannedOn on : kPlannedOn) {
    const bool is_executed =
        std::find(executed.begin(), executed.end(), to_string(on)) != executed.end();
    if (!is_executed && on != PlannedOn::kTruth) continue;
    settings.push_back({to_string(on), on, {}, {}, is_executed});
    // The truth is not wider than the object.
    if (on != PlannedOn::kTruth) continue;
    settings.back().change = [](planning::PlatformPlanOptions* options) {
      options->grasps.pads.width_tolerance = 0;
    };
  }
  return settings;
}

ChainOptions chain_options(const fidelity::ChosenChain& chain) {
  ChainOptions options;
  fidelity::apply_first_stage(chain.front, chain.setting, &options.seeing);
  options.shape =
      fidelity::shape_options(stage_setting(chain.front, chain.setting, fidelity::Stage::kShape));
  options.plan = change_by(chain.front, chain.setting);
  return options;
}

GraspCase run_grasp_case(const Case& one, const PlatformUnderTest& platform,
                         const std::vector<PlannerSetting>& settings, belief::EvidenceUse evidence,
                         const ChainOptions& chain) {
  GraspCase result;
  result.case_name = one.name();
  result.group = one.data_set->group;
  result.data_set = one.data_set->name;
  result.orientation = one.orientation;
  result.platform = platform.name();

  const geometry::TriangleMesh& mesh_B = *one.data_set->mesh_B;
  const double mass = household_mass(geometry::mass_properties(mesh_B).volume);
  std::vector<geometry::TriangleMesh> others_W;
  for (const auto& other_B : one.data_set->viewing.others_B) {
    others_W.push_back(geometry::transformed(*other_B, one.X_WB()));
  }
  const geometry::RigidTransform X_WB = resting_pose(mesh_B, one.X_WB(), mass, others_W);
  const TrueObject truth{geometry::transformed(mesh_B, X_WB), mass, others_W};
  result.others = static_cast<int>(others_W.size());
  std::optional<SeenObject> seen;
  try {
    seen = see_object(one, X_WB, 0, chain.seeing);
  } catch (const std::exception& error) {
    result.problem = error.what();
  }
  belief::AttemptMemoryOptions memory_options;
  memory_options.use = evidence;
  std::map<std::pair<PlannedOn, int>, Belief> first_look;
  for (PlannerSetting setting : settings) {
    const PlannedOn on = setting.planned_on;
    if (chain.plan && on != PlannedOn::kTruth) setting.change = chain.plan;
    GraspTrial trial;
    try {
      if (on != PlannedOn::kTruth && !seen) {
        throw geometry::InputError(result.problem, "Look from elsewhere");
      }
      fidelity::ShapeOptions shapes = chain.shape;
      if (setting.alternatives > 0) shapes.completion.alternatives = setting.alternatives;
      const std::pair key(on, setting.alternatives);
      if (!first_look.contains(key)) {
        const double start = processor_time();
        first_look[key] = on == PlannedOn::kTruth ? belief_of(truth.mesh_W, others_W)
                                                  : believed_object(one, *seen, on, shapes);
        if (on == PlannedOn::kPredicted) result.predict_seconds = processor_time() - start;
      }
      int look = 0, recalled = 0;
      Belief believed = first_look.at(key);
      belief::AttemptMemory memory(platform.hand(), memory_options);
      trial = platform.grasp(
          first_look.at(key), truth, setting,
          [&](const geometry::RigidTransform& X_moved, const belief::Attempt& attempt) {
            if (on == PlannedOn::kTruth) {
              return belief_of(geometry::transformed(truth.mesh_W, X_moved), others_W);
            }
            if (believed.shape) {
              memory.add(attempt, *believed.shape, believed.support_W, believed.object.mesh_W,
                         believed.others.meshes_W);
            }
            believed = believed_object(one, see_object(one, X_moved * X_WB, ++look, chain.seeing),
                                       on, shapes);
            if (believed.shape) {
              if (auto known = memory.recall(*believed.shape, believed.support_W)) {
                believed.object = std::move(known->model);
                ++recalled;
              }
            }
            return believed;
          });
      trial.recalled = recalled;
    } catch (const std::exception& error) {
      trial.problem = error.what();
      trial.stage = on != PlannedOn::kTruth && !seen ? "view" : "plan";
    }
    trial.setting = setting.name;
    trial.is_planned_only = !setting.is_executed;
    result.trials.push_back(std::move(trial));
  }
  return result;
}

}  // namespace prehend::eval
