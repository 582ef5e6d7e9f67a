#include "prehend/planning/hand_plan.h"

#include <algorithm>
#include <utility>

namespace prehend::planning {
namespace {

using geometry::RigidTransform;

constexpr double kLeastEffort = 1e-3;  // share; of grasps that need next to none

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
  return result;
}

PlannedGrasp with_fingers(const grasp::HandGrasp& grasp, double mass, double grip_force) {
  PlannedGrasp result = common_part(grasp, grasp.preshape, grasp.open);
  result.closed = grasp.closed;
  result.all = grasp.closed_all;
  result.force = grip_force;
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
    for (const auto& grasp : plan.grasps) {
      result.grasps.push_back(with_fingers(grasp, plan.mass, options.grip_force));
    }
  }
  result.remembered = remembered;
  return result;
}

void add_touch(const robot::HandModel& hand, const surface::ObjectModel& object,
               const geometry::Plane& table, const TouchPredictionOptions& options,
               std::vector<PlannedGrasp>* grasps) {
  if (grasps->empty()) return;
  std::vector<GraspToFeel> to_feel;
  for (const PlannedGrasp& grasp : *grasps) {
    to_feel.push_back({grasp.pose.X_WG, grasp.pose.preshape, grasp.pose.open, grasp.closed,
                       grasp.force, std::clamp(grasp.effort, kLeastEffort, 1.0)});
  }
  const ObjectToFeel body{object.mesh_W, table, grasps->front().predicted.lifted_mass};
  std::vector<PredictedTouch> touches = predict_touches(hand, to_feel, body, options);
  for (std::size_t i = 0; i < grasps->size(); ++i) {
    PlannedGrasp& grasp = (*grasps)[i];
    grasp.touch = std::move(touches[i]);
    const bool known = grasp.touch.outcome == TouchOutcome::kPredicted;
    if (!known && !grasp.touch.is_refuted()) continue;
    grasp.predicted.contact_area = grasp.touch.mean.area;
    grasp.predicted.tactile_sum = grasp.touch.mean.sum;
  }
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
