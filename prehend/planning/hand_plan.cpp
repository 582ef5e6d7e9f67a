#include "prehend/planning/hand_plan.h"

#include <algorithm>
#include <utility>

namespace prehend::planning {
namespace {

using geometry::RigidTransform;

template <class Plan>
HandPlanResult common_part(const Plan& plan) {
  HandPlanResult result;
  result.rejections = plan.rejections;
  result.candidates = plan.candidates;
  result.problem = plan.problem;
  return result;
}

template <class Grasp>
PlannedGrasp common_part(const Grasp& grasp, const std::string& preshape,
                         const Eigen::VectorXd& open) {
  PlannedGrasp result;
  result.pose = {grasp.X_WG,
                 grasp.approach_W,
                 grasp.pregrasp_distance,
                 preshape,
                 open,
                 std::clamp(grasp.score, 0.0, 1.0)};
  result.roll = grasp.roll;
  result.score = grasp.score;
  result.quality = grasp.quality;
  result.robustness = grasp.robustness;
  result.guessed_contact = grasp.guessed_contact;
  result.generator = grasp.generator;
  result.remark = grasp.remark;
  return result;
}

PlannedGrasp with_pads(const robot::HandModel& hand, const grasp::Grasp& grasp) {
  // The joint of a parallel gripper is half of its opening.
  const auto joints = [](double opening) {
    return Eigen::VectorXd(Eigen::VectorXd::Constant(1, opening / 2));
  };
  PlannedGrasp result =
      common_part(grasp, hand.preshapes.front().name, joints(grasp.pregrasp_opening));
  result.closed = joints(grasp.predicted.opening);
  result.all = hand.all_positions(result.closed);
  result.force = grasp.grasp_force;
  const robot::GripperModel& gripper = *hand.gripper;
  result.effort = grasp.grasp_force /
                  (gripper.nominal_current * gripper.force_per_current - gripper.friction_force);
  result.predicted = grasp.predicted;
  result.contacts_W = grasp.left_contacts_W;
  result.contacts_W.insert(result.contacts_W.end(), grasp.right_contacts_W.begin(),
                           grasp.right_contacts_W.end());
  result.pads = grasp;
  return result;
}

PlannedGrasp with_fingers(const grasp::HandGrasp& grasp, double mass) {
  PlannedGrasp result = common_part(grasp, grasp.preshape, grasp.open);
  result.closed = grasp.closed;
  result.all = grasp.closed_all;
  result.effort = grasp.effort;
  result.predicted.lifted_mass = mass;
  for (const grasp::HandContact& contact : grasp.contacts) {
    result.contacts_W.push_back(contact.contact_W.point);
  }
  return result;
}

}  // namespace

HandPlanResult plan_hand(const grasp::HandToClose& hand, const surface::ObjectModel& object,
                         const geometry::Plane& table, const grasp::Obstacles& obstacles,
                         const grasp::Reachability& reachability, const HandPlanOptions& options,
                         grasp::GraspDatabase* database,
                         const std::optional<grasp::PlacedObject>& known) {
  const bool remembers = database && known;
  grasp::Remembered remembered;
  HandPlanResult result;
  if (hand.hand->gripper) {
    const robot::GripperModel& gripper = *hand.hand->gripper;
    const auto plan =
        remembers ? plan_grasps_with_memory(*database, *known, object, table, obstacles, gripper,
                                            reachability, options.pads, &remembered)
                  : plan_grasps(object, table, obstacles, gripper, reachability, options.pads);
    result = common_part(plan);
    for (const auto& grasp : plan.grasps) result.grasps.push_back(with_pads(*hand.hand, grasp));
  } else {
    const auto plan =
        remembers ? plan_hand_grasps_with_memory(*database, *known, object, table, obstacles, hand,
                                                 reachability, options.fingers, &remembered)
                  : plan_hand_grasps(object, table, obstacles, hand, reachability, options.fingers);
    result = common_part(plan);
    for (const auto& grasp : plan.grasps) result.grasps.push_back(with_fingers(grasp, plan.mass));
  }
  result.remembered = remembered;
  return result;
}

grasp::Reachability within_reach(grasp::Reachability reachability,
                                 const robot::Platform& platform) {
  if (!reachability.approach_W) {
    reachability.approach_W = platform.fixed_approach(platform.hand.preshapes.front());
  }
  return reachability;
}

HandPlanOptions within_reach(HandPlanOptions options, const robot::Platform& platform) {
  options.fingers.reaches = arm_reach(platform);
  // Of a parallel gripper every preshape has the one tool.
  options.pads.reaches =
      [reaches = options.fingers.reaches,
       X_GH = (platform.hand.X_HP * platform.hand.preshapes.front().X_PG).inverse()](
          const RigidTransform& X_WG) { return reaches(X_WG * X_GH); };
  return options;
}

}  // namespace prehend::planning
