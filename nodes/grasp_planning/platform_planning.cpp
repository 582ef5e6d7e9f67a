#include "nodes/grasp_planning/platform_planning.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include "msgs/convert/cycle.h"
#include "msgs/convert/decision.h"
#include "msgs/convert/fidelity.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/grasp.h"
#include "msgs/convert/images.h"
#include "msgs/convert/joint_positions.h"
#include "msgs/convert/outcomes.h"
#include "msgs/convert/remedies.h"
#include "msgs/convert/touch.h"
#include "nodes/grasp_planning/task_places.h"
#include "nodes/grasp_planning/touch_parameters.h"
#include "prehend/control/planned_grasp.h"

namespace prehend::nodes {
namespace {

constexpr double kAtHome = 1e-3;  // rad or m

void add_time(const char* stage, double seconds, msgs::GraspPlan* message) {
  msgs::StageTime& time = *message->add_times();
  time.set_stage(stage);
  time.set_seconds(seconds);
}

}  // namespace

PlatformPlanning::PlatformPlanning(robot::Platform platform, const std::string& home,
                                   planning::PlatformPlanOptions options,
                                   const std::optional<fidelity::Setting>& touch,
                                   control::Task task)
    : home_(platform.home(home).arm),
      start_(home_),
      planner_(std::move(platform)),
      options_(std::move(options)),
      task_(std::move(task)) {
  options_.validate();
  if (touch) touch_fidelity_ = convert::to_message(*touch);
}

void PlatformPlanning::set_gripper(const robot::GripperModel& gripper) {
  planner_.set_gripper(gripper);
}

void PlatformPlanning::view_by(const msgs::CameraInfo& camera) {
  const std::optional<geometry::RigidTransform> X_WC = convert::camera_pose(camera);
  options_.viewing.reset();
  if (X_WC) options_.viewing = planning::ViewingCamera{convert::from_message(camera).left, *X_WC};
  if (looks()) options_.carried_camera = convert::from_message(camera);
}

void PlatformPlanning::start_from(const msgs::JointState& joints) {
  const auto now = convert::positions_of(planner_.platform().arm_chain(), joints);
  if (!now) return;
  start_ = (*now - home_).cwiseAbs().maxCoeff() < kAtHome ? home_ : *now;
}

msgs::Grasp PlatformPlanning::to_message(const planning::PlannedPick& pick) const {
  msgs::Grasp message = convert::to_message(pick.grasp, planner_.platform().hand);
  convert::add_touch(pick.touch, planner_.platform().hand, message.mutable_predicted());
  if (pick.move_W) *message.mutable_move() = convert::to_message(*pick.move_W);
  convert::add_motion(control::arm_grasp(planner_.platform(), pick), &message);
  if (inspects() && !options_.viewing) {
    message.set_held_views_problem("no camera has said where it stands (/camera/info)");
  }
  return message;
}

msgs::GraspPlan PlatformPlanning::plan(
    const surface::ObjectModel& object, const geometry::Plane& table_W,
    const planning::Neighbours& neighbours, const grasp::Reachability& reachability,
    grasp::GraspDatabase* database, const std::optional<grasp::PlacedObject>& known,
    const grasp::LoadBounds& load, const std::vector<planning::ProbeWay>& probes,
    double shape_confidence, const std::vector<planning::PushLine>& made,
    double remedy_budget) const {
  std::vector<Eigen::Vector3d> points;
  for (const auto& piece : object.convex_pieces_W) {
    points.insert(points.end(), piece.vertices.begin(), piece.vertices.end());
  }
  planning::PlatformPlanOptions options = options_;
  options.place = places_of(task_, points, options.place);
  options.load = load;
  options.probes = probes;
  options.shape_confidence = shape_confidence;
  if (task_.does(control::Primitive::kPush)) options.push.emplace().made = made;
  options.remedies.budget = remedy_budget;
  const planning::PlatformPlan plan =
      planner_.plan(object, table_W, neighbours, reachability, start_, options, database, known);
  msgs::GraspPlan message;
  message.set_candidates(static_cast<std::uint32_t>(plan.candidates));
  message.set_outcome(convert::to_message(plan.outcome));
  message.set_problem(plan.problem);
  convert::add_rejections(plan.rejections, &message);
  for (const auto& rejected : plan.arm_rejections) {
    auto& rejection = *message.add_rejections();
    rejection.set_reason(std::string("arm: ") + motion::to_string(rejected.filter));
    rejection.set_count(static_cast<std::uint32_t>(rejected.count));
    rejection.set_nearest_miss(rejected.nearest_miss);
  }
  convert::add_remedies(plan.remedies, &message);
  const bool was_asked_for = options_.remedies.budget > 0;
  if (was_asked_for && remedy_budget == 0 && message.outcome() != msgs::GraspPlan::GRASPABLE) {
    message.set_remedies_incomplete(true);
  }
  convert::add_choices(plan.choices, &message);
  if (plan.remedy_time > 0) {
    add_time(kRemediesStage, plan.remedy_time, &message);
  }
  if (touch_fidelity_) *message.mutable_touch_fidelity() = *touch_fidelity_;
  if (plan.touch_time > 0) {
    add_time(kTouchStage, plan.touch_time, &message);
  }
  for (const auto& pick : plan.picks) *message.add_grasps() = to_message(pick);
  if (const auto probe = control::arm_probe(planner_.platform(), plan.probe)) {
    *message.mutable_probe() = convert::to_message(plan.probe.hand, planner_.platform().hand);
    convert::add_motion(*probe, message.mutable_probe());
  }
  if (plan.probe_time > 0) {
    add_time("probe", plan.probe_time, &message);
    message.mutable_probe()->set_remark(plan.probe.problem);
  }
  if (plan.push_time > 0) {
    add_time("push", plan.push_time, &message);
    msgs::Grasp& push = *message.mutable_push();
    push.set_remark(plan.push.problem);
    if (const auto way = control::arm_push(planner_.platform(), plan.push)) {
      push = convert::to_message(plan.push.hand, planner_.platform().hand);
      push.set_score(plan.push.worth);
      convert::add_motion(*way, &push);
    }
  }
  if (plan.look_time > 0) {
    add_time("look", plan.look_time, &message);
    msgs::PlannedLook& look = *message.mutable_look();
    look.set_problem(plan.look.problem);
    look.set_from(plan.look.from);
    look.set_gain(plan.look.gain);
    if (plan.look.found()) {
      *look.mutable_way() = convert::to_message(control::look_way(planner_.platform(), plan.look));
      *look.mutable_x_wc() = convert::to_message(plan.look.X_WC);
    }
  }
  return message;
}

}  // namespace prehend::nodes
