#include "prehend/planning/platform_plan.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "prehend/text/require.h"

namespace prehend::planning {

void PlatformPlanOptions::validate() const {
  grasps.validate();
  place.validate();
  text::Require{"PlatformPlanOptions."}(motions > 0, "motions must be positive");
}

PlatformPlanner::PlatformPlanner(robot::Platform platform)
    : platform_(std::move(platform)), hand_(platform_.hand) {}

void PlatformPlanner::set_gripper(const robot::GripperModel& gripper) {
  platform_.set_gripper(gripper);
  hand_ = grasp::HandToClose(platform_.hand);
}

PlatformPlan PlatformPlanner::plan(const surface::ObjectModel& object,
                                   const geometry::Plane& table_W,
                                   const Neighbours& neighbours,
                                   const grasp::Reachability& reachability,
                                   const robot::Positions& start,
                                   const PlatformPlanOptions& options,
                                   grasp::GraspDatabase* database,
                                   const std::optional<grasp::PlacedObject>& known) const {
  options.validate();
  grasp::Obstacles obstacles;
  obstacles.meshes_W = platform_.hand.gripper ? neighbours.meshes_W : neighbours.pieces_W;
  const grasp::Reachability reach = within_reach(reachability, platform_);
  const grasp::PlannerOptions reaching = within_reach(options.grasps, platform_);
  grasp::GraspPlan grasps =
      database && known
          ? plan_grasps_with_memory(*database, *known, object, table_W, obstacles, hand_, reach,
                                    reaching)
          : plan_grasps(object, table_W, obstacles, hand_, reach, reaching);
  PlatformPlan plan;
  plan.rejections = std::move(grasps.rejections);
  plan.candidates = grasps.candidates;
  plan.problem = grasps.problem;
  for (const grasp::Grasp& grasp : grasps.grasps) {
    plan.robustness = std::max(plan.robustness, grasp.robustness);
  }
  if (!grasps.grasps.empty()) {
    add_motions(std::move(grasps.grasps), {table_W, object.convex_pieces_W, neighbours.pieces_W}, start,
                options, &plan);
  }
  return plan;
}

// The grasps that the arm can execute, best first, and then the others; or why there is none.
void PlatformPlanner::add_motions(std::vector<grasp::Grasp> grasps, const PlatformScene& scene,
                                  const robot::Positions& start, const PlatformPlanOptions& options,
                                  PlatformPlan* plan) const {
  const FreePlaces places = free_places_for(platform_, scene, options.place);
  if (!places.problem.empty()) {
    plan->problem = "cannot be grasped: " + places.problem + ". " + kPlaceMend;
    return;
  }
  PlatformPickOptions arm = options.arm;
  arm.moves_W = places.moves_W;
  const std::size_t all = grasps.size();
  std::string arm_problem;
  for (int i = 0; i < options.motions && !grasps.empty(); ++i) {
    std::vector<PlatformGrasp> poses;
    for (const grasp::Grasp& grasp : grasps) poses.push_back(to_pick(grasp));
    PlatformPick pick = plan_platform_pick(platform_, start, poses, scene, arm);
    if (i == 0) plan->arm_rejections = pick.motion.rejections;
    if (!pick.motion.found()) {
      arm_problem = pick.motion.problem;
      break;
    }
    PlannedPick planned;
    planned.grasp = std::move(grasps[static_cast<std::size_t>(pick.grasp)]);
    planned.segments = std::move(pick.motion.segments);
    if (pick.motion.place >= 0) {
      planned.move_W = arm.moves_W[static_cast<std::size_t>(pick.motion.place)];
    }
    plan->picks.push_back(std::move(planned));
    grasps.erase(grasps.begin() + pick.grasp);
  }
  if (plan->picks.empty()) {
    plan->problem = fmt::format("cannot be grasped: the arm can execute none of {} grasps: {}", all,
                                arm_problem);
    return;
  }
  for (grasp::Grasp& grasp : grasps) plan->picks.push_back({std::move(grasp), {}, std::nullopt});
}

}  // namespace prehend::planning
