#include "tools/grasp_plan/planned.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "prehend/fidelity/plan_settings.h"
#include "prehend/geometry/errors.h"
#include "prehend/grasp/generators/generator_registry.h"
#include "prehend/robot/robot_files.h"

namespace prehend::tools {
namespace {

namespace fs = std::filesystem;
using std::chrono::steady_clock;

grasp::Obstacles obstacles_of(const PlanTarget& target) {
  grasp::Obstacles obstacles;
  for (const auto& pieces : target.neighbours_W) {
    obstacles.meshes_W.insert(obstacles.meshes_W.end(), pieces.begin(), pieces.end());
  }
  return obstacles;
}

grasp::Reachability reachability_of(const PlanChoices& choices, const Planned& planned) {
  grasp::Reachability reachability;
  if (choices.approach == "down") reachability.approach_W = -Eigen::Vector3d::UnitZ();
  return planned.platform ? planning::within_reach(reachability, *planned.platform) : reachability;
}

// Grasps of a predicted shape are of no use again.
std::optional<grasp::GraspDatabase> database_of(const PlanChoices& choices,
                                                const PlanTarget& target) {
  if (choices.database.empty() || !target.known) return std::nullopt;
  return grasp::GraspDatabase(choices.database);
}

// What no knob of the hand, or of the arm, took.
void refuse_misfits(const std::map<std::string, double>& given, const std::string& prefix,
                    const std::string& with) {
  if (given.empty()) return;
  std::string option = "--" + prefix + given.begin()->first;
  std::replace(option.begin(), option.end(), '_', '-');
  throw geometry::InputError(option + " does not apply with " + with, "Leave it out");
}

// The front was measured with these.
void refuse_chosen(const PlanChoices& choices) {
  if (choices.grasp_knobs.count("robustness_samples") == 0) return;
  throw geometry::InputError(
      "--robustness-samples does not apply beside --budget, which chooses it for the PG70",
      "Give one of the two, or --generators");
}

grasp::PlannerOptions options_of(const PlanChoices& choices,
                                 const std::optional<fidelity::ChosenChain>& chain,
                                 Planned* planned) {
  grasp::PlannerOptions options = grasp::default_options(planned->hand);
  if (!choices.generators.empty()) {
    const grasp::GeneratorRegistry known;
    for (const std::string& name : choices.generators) known.create(name);
    options.generators = choices.generators;
    options.further_generators.clear();
  }
  std::map<std::string, double> given = choices.grasp_knobs;
  const text::SetKnobs set{&given};
  grasp::PlannerOptions::knobs(options, set);
  if (planned->hand.gripper) {
    grasp::PadOptions::knobs(options.pads, set);
  } else {
    grasp::FingerOptions::knobs(options.fingers, set);
  }
  refuse_misfits(given, "", "the hand " + planned->hand.name);
  if (chain) {
    planned->chosen =
        fidelity::apply_plan_front(chain->front, options.budget, choices.tolerance, &options).text;
  } else if (choices.generators.empty() && options.budget > 0 && planned->hand.gripper) {
    refuse_chosen(choices);
    const auto front = fidelity::read_front(fs::path(choices.config) / "fidelity" / "plan.yaml");
    planned->chosen = fidelity::apply_plan_front(front, options.budget, 0, &options).text;
  }
  options.candidates.seed = options.uncertainty.seed = choices.seed;
  options.preshapes = choices.preshapes;
  return options;
}

// Names that are unknown are refused before anything is planned.
planning::PlatformPickOptions arm_options(const PlanChoices& choices) {
  planning::PlatformPickOptions options;
  if (!choices.path_planner.empty()) {
    options.pick.planner = motion::PlannerRegistry().create(choices.path_planner)->name();
  }
  if (!choices.collision_checker.empty()) {
    motion::CheckerRegistry().create(choices.collision_checker);
    options.checker = choices.collision_checker;
  }
  options.pick.path.seed = choices.seed;
  if (const auto budget = choices.grasp_knobs.find("budget"); budget != choices.grasp_knobs.end()) {
    options.pick.budget = budget->second;
  }
  std::map<std::string, double> given = choices.arm_knobs;
  planning::PlatformPickOptions::knobs(options, text::SetKnobs{&given});
  if (!choices.move.empty()) {
    options.moves_W = {{choices.move[0], choices.move[1], choices.move[2]}};
  }
  return options;
}

planning::PlatformScene scene_of(const PlanTarget& target) {
  planning::PlatformScene scene;
  scene.table_W = target.table_W;
  scene.object_pieces_W = target.object.convex_pieces_W;
  for (const auto& pieces : target.neighbours_W) {
    scene.obstacle_pieces_W.insert(scene.obstacle_pieces_W.end(), pieces.begin(), pieces.end());
  }
  return scene;
}

std::vector<planning::PlatformGrasp> picks_of(const Planned& planned) {
  std::vector<planning::PlatformGrasp> grasps;
  for (const grasp::Grasp& grasp : planned.plan.grasps) grasps.push_back(planning::to_pick(grasp));
  return grasps;
}

// Of the grasp that is executed and the two best ones beside it.
std::vector<planning::Choice> choices_of(const PlanChoices& choices, const PlanTarget& target,
                                         const Planned& planned) {
  constexpr std::size_t kMost = 3;
  planning::DecisionOptions options;
  std::map<std::string, double> given = choices.decision_knobs;
  planning::DecisionOptions::knobs(options, text::SetKnobs{&given});
  options.validate();
  const auto& grasps = planned.plan.grasps;
  std::size_t first = 0;
  if (planned.arm) {
    if (!planned.arm->motion.found()) return {};
    first = static_cast<std::size_t>(planned.arm->grasp);
  }
  std::vector<const grasp::Grasp*> tried;
  if (first < grasps.size()) tried.push_back(&grasps[first]);
  for (std::size_t i = 0; i < grasps.size() && tried.size() < kMost; ++i) {
    if (i != first) tried.push_back(&grasps[i]);
  }
  return planning::decide_on(target.object, tried, planned.hand.gripper.has_value(), options);
}

}  // namespace

Planned make_plan(const PlanChoices& choices, const PlanTarget& target, Progress& progress) {
  Planned planned;
  const fs::path robots = fs::path(choices.config) / "robots";
  if (!choices.platform.empty()) {
    planned.platform = robot::read_platform(robot::platform_file(robots, choices.platform));
  }
  if (!planned.platform) refuse_misfits(choices.arm_knobs, "arm_", "a hand without an arm");
  const planning::PlatformPickOptions arm = arm_options(choices);
  const planning::RemedyOptions remedy{choices.remedy_budget};
  planned.hand = planned.platform ? planned.platform->hand
                                  : robot::read_hand_model(robot::hand_file(robots, choices.hand));
  auto start = steady_clock::now();
  const auto stage = [&](const std::string& name) {
    planned.times.emplace_back(name,
                               std::chrono::duration<double>(steady_clock::now() - start).count());
    start = steady_clock::now();
  };
  progress.stage("planning grasps on " + with_commas(target.object.mesh_W.triangles.size()) +
                 " triangles");
  auto database = database_of(choices, target);
  const grasp::HandToClose hand(planned.hand);
  const grasp::Obstacles obstacles = obstacles_of(target);
  const grasp::Reachability reachability = reachability_of(choices, planned);
  grasp::PlannerOptions options = options_of(choices, target.chain, &planned);
  if (planned.platform) {
    options.reaches = planning::arm_reach_over_table(*planned.platform, scene_of(target), arm);
  }
  planned.plan = database ? grasp::plan_grasps_with_memory(
                                *database, *target.known, target.object, target.table_W, obstacles,
                                hand, reachability, options, &planned.remembered)
                          : grasp::plan_grasps(target.object, target.table_W, obstacles, hand,
                                               reachability, options);
  stage("grasps");
  if (planned.platform && !planned.plan.grasps.empty()) {
    progress.stage("planning the arm's motion");
    const planning::PlatformScene scene = scene_of(target);
    const std::vector<planning::PlatformGrasp> grasps = picks_of(planned);
    const robot::Positions& home = planned.platform->home("home").arm;
    planned.arm = planning::plan_platform_pick(*planned.platform, home, grasps, scene, arm);
    stage("arm");
    if (!planned.arm->motion.found() && remedy.budget > 0) {
      progress.stage("finding out what would help");
      planned.remedies =
          planning::remedies_for_motion(*planned.platform, home, grasps, scene, arm, remedy);
      stage("remedies");
    }
  }
  planned.choices = choices_of(choices, target, planned);
  if (planned.plan.grasps.empty() && remedy.budget > 0) {
    progress.stage("finding out what would help");
    planned.remedies =
        planning::remedies_for_grasps(target.object, target.table_W, obstacles, planned.hand,
                                      reachability, options, planned.plan.rejections, remedy);
    stage("remedies");
  }
  return planned;
}

}  // namespace prehend::tools
