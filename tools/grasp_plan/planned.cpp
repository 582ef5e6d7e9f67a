#include "tools/grasp_plan/planned.h"

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "prehend/fidelity/plan_settings.h"
#include "prehend/geometry/errors.h"
#include "prehend/grasp/grasp_memory.h"

namespace prehend::tools {
namespace {

namespace fs = std::filesystem;
using std::chrono::steady_clock;

struct PlatformFile {
  const char* arm;
  const char* hand;
  const char* file;
};
constexpr PlatformFile kPlatforms[] = {{"kr5", "pg70", "kr5_pg70.yaml"},
                                       {"kr5", "sdh2", "kr5_sdh.yaml"},
                                       {"pa10", "bh8", "pa10_barrett.yaml"}};

fs::path platform_file(const PlanChoices& choices) {
  std::string known;
  for (const PlatformFile& platform : kPlatforms) {
    if (choices.arm == platform.arm && choices.hand == platform.hand) {
      return fs::path(choices.config) / "robots" / platform.file;
    }
    known += std::string(known.empty() ? "" : ", ") + platform.arm + " with " + platform.hand;
  }
  throw geometry::InputError(
      "There is no platform of the arm " + choices.arm + " with the hand " + choices.hand,
      "Take one of " + known + ", or --arm none");
}

grasp::Obstacles obstacles_of(const PlanTarget& target) {
  grasp::Obstacles obstacles;
  for (const auto& pieces : target.neighbours_W) {
    obstacles.meshes_W.insert(obstacles.meshes_W.end(), pieces.begin(), pieces.end());
  }
  return obstacles;
}

grasp::Reachability reachability_of(const PlanChoices& choices) {
  grasp::Reachability reachability;
  if (choices.approach == "down") reachability.approach_W = -Eigen::Vector3d::UnitZ();
  return reachability;
}

// Grasps of a predicted shape are of no use again.
std::optional<grasp::GraspDatabase> database_of(const PlanChoices& choices,
                                                const PlanTarget& target) {
  if (choices.database.empty() || !target.known) return std::nullopt;
  return grasp::GraspDatabase(choices.database);
}

void plan_gripper(const PlanChoices& choices, const PlanTarget& target, Planned* planned) {
  grasp::PlannerOptions options;
  options.density = choices.density;
  options.budget = choices.budget;
  if (!choices.generators.empty()) {
    options.generators = choices.generators;
    options.further_generators.clear();
  } else if (choices.budget > 0) {
    const auto front = fidelity::read_front(fs::path(choices.config) / "fidelity" / "plan.yaml");
    planned->chosen = fidelity::apply_plan_budget(front, choices.budget, &options);
  }
  options.candidates.seed = options.uncertainty.seed = choices.seed;
  const auto gripper =
      robot::read_gripper_model(fs::path(choices.config) / "robots" / "pg70_dsa.yaml");
  const auto obstacles = obstacles_of(target);
  const auto reachability = reachability_of(choices);
  auto database = database_of(choices, target);
  const auto plan = database ? grasp::plan_grasps_with_memory(
                                   *database, *target.known, target.object, target.table_W,
                                   obstacles, gripper, reachability, options, &planned->remembered)
                             : grasp::plan_grasps(target.object, target.table_W, obstacles, gripper,
                                                  reachability, options);
  planned->rejections = plan.rejections;
  planned->candidates = plan.candidates;
  planned->problem = plan.problem;
  const double largest =
      gripper.nominal_current * gripper.force_per_current - gripper.friction_force;
  // The model's joint is half of the opening.
  const auto joints = [](double opening) { return Eigen::VectorXd::Constant(1, opening / 2); };
  for (const grasp::Grasp& grasp : plan.grasps) {
    PlannedGrasp one;
    one.pose = {grasp.X_WG, grasp.approach_W, grasp.pregrasp_distance,
                planned->hand.preshapes.front().name, joints(grasp.pregrasp_opening)};
    one.all = planned->hand.all_positions(joints(grasp.predicted.opening));
    one.score = grasp.score;
    one.quality = grasp.quality;
    one.robustness = grasp.robustness;
    one.effort = grasp.grasp_force / largest;
    one.generator = grasp.generator;
    one.remark = grasp.remark;
    planned->grasps.push_back(std::move(one));
  }
}

void plan_fingers(const PlanChoices& choices, const PlanTarget& target, Planned* planned) {
  grasp::HandPlannerOptions options;
  if (!choices.generators.empty()) {
    options.generators = choices.generators;
    options.further_generators.clear();
  }
  options.preshapes = choices.preshapes;
  options.density = choices.density;
  options.budget = choices.budget;
  options.candidates.seed = choices.seed;
  if (planned->platform) options.reaches = planning::arm_reach(*planned->platform);
  const auto obstacles = obstacles_of(target);
  const auto reachability = reachability_of(choices);
  const grasp::HandToClose hand(planned->hand);
  auto database = database_of(choices, target);
  const auto plan = database ? grasp::plan_hand_grasps_with_memory(
                                   *database, *target.known, target.object, target.table_W,
                                   obstacles, hand, reachability, options, &planned->remembered)
                             : grasp::plan_hand_grasps(target.object, target.table_W, obstacles,
                                                       hand, reachability, options);
  planned->rejections = plan.rejections;
  planned->candidates = plan.candidates;
  planned->problem = plan.problem;
  for (const grasp::HandGrasp& grasp : plan.grasps) {
    PlannedGrasp one;
    one.pose = {grasp.X_WG, grasp.approach_W, grasp.pregrasp_distance, grasp.preshape, grasp.open};
    one.all = grasp.closed_all;
    one.score = grasp.score;
    one.quality = grasp.quality;
    one.robustness = grasp.robustness;
    one.effort = grasp.effort;
    one.generator = grasp.generator;
    one.remark = grasp.remark;
    planned->grasps.push_back(std::move(one));
  }
}

void plan_arm(const PlanChoices& choices, const PlanTarget& target, Planned* planned) {
  planning::PlatformPickOptions options;
  options.pick.rrt.seed = choices.seed;
  if (choices.budget > 0) options.pick.budget = choices.budget;
  if (!choices.move.empty()) {
    options.moves_W = {{choices.move[0], choices.move[1], choices.move[2]}};
  }
  planning::PlatformScene scene;
  scene.table_W = target.table_W;
  scene.object_pieces_W = target.object.convex_pieces_W;
  for (const auto& pieces : target.neighbours_W) {
    scene.obstacle_pieces_W.insert(scene.obstacle_pieces_W.end(), pieces.begin(), pieces.end());
  }
  std::vector<planning::PlatformGrasp> grasps;
  for (const PlannedGrasp& grasp : planned->grasps) {
    grasps.push_back(grasp.pose);
    grasps.back().expected_success = std::clamp(grasp.score, 0.0, 1.0);
  }
  planned->arm = planning::plan_platform_pick(
      *planned->platform, planned->platform->home("home").arm, grasps, scene, options);
}

}  // namespace

Planned make_plan(const PlanChoices& choices, const PlanTarget& target, Progress& progress) {
  Planned planned;
  const fs::path robots = fs::path(choices.config) / "robots";
  if (choices.arm != "none") planned.platform = robot::read_platform(platform_file(choices));
  planned.hand = planned.platform ? planned.platform->hand
                                  : robot::read_hand_model(robots / (choices.hand + ".yaml"));
  auto start = steady_clock::now();
  const auto stage = [&](const std::string& name) {
    planned.times.emplace_back(name,
                               std::chrono::duration<double>(steady_clock::now() - start).count());
    start = steady_clock::now();
  };
  progress.stage("planning grasps on " + with_commas(target.object.mesh_W.triangles.size()) +
                 " triangles");
  if (choices.hand == "pg70") {
    plan_gripper(choices, target, &planned);
  } else {
    plan_fingers(choices, target, &planned);
  }
  stage("grasps");
  if (planned.platform && !planned.grasps.empty()) {
    progress.stage("planning the arm's motion");
    plan_arm(choices, target, &planned);
    stage("arm");
  }
  return planned;
}

}  // namespace prehend::tools
