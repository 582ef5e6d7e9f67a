#include "msgs/convert/cycle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/mend.h"
#include "msgs/convert/outcomes.h"
#include "prehend/geometry/errors.h"
#include "prehend/planning/decision.h"

namespace prehend::convert {
namespace {

constexpr double kLeastWay = 1e-3;  // rad, of a joint that closes

template <class Values>
Eigen::VectorXd vector_of(const Values& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), values.size());
}

robot::ClosingWay closing_way_of(const msgs::Grasp& grasp) {
  robot::ClosingWay way;
  way.open = vector_of(grasp.open_position());
  way.closed = vector_of(grasp.closed_position());
  if (grasp.closing_rate_size() > 0) {
    way.rate = vector_of(grasp.closing_rate());
    way.lower = vector_of(grasp.least_position());
    way.upper = vector_of(grasp.largest_position());
    return way;
  }
  const double infinity = std::numeric_limits<double>::infinity();
  way.rate = (way.closed - way.open).unaryExpr([](double closes) {
    return std::abs(closes) > kLeastWay ? std::copysign(1.0, closes) : 0.0;
  });
  way.lower = Eigen::VectorXd::Constant(way.closed.size(), -infinity);
  way.upper = Eigen::VectorXd::Constant(way.closed.size(), infinity);
  return way;
}

// How the hand adapts; all of it or nothing.
void add_shifts(const msgs::Grasp& message, control::ArmGrasp* grasp) {
  const auto approach = std::find_if(
      grasp->segments.begin(), grasp->segments.end(),
      [](const auto& segment) { return segment.first == motion::SegmentKind::kApproach; });
  const std::size_t joints = approach == grasp->segments.end() ? 0 : approach->second.joints.size();
  bool sound =
      message.shift().empty() || message.fingertip_way_size() == message.hand_joint_name_size();
  for (const msgs::HandShift& shift : message.shift()) {
    grasp->shifts.push_back(
        {from_message(shift.way()), {shift.offset().begin(), shift.offset().end()}});
    const std::vector<double>& offsets = grasp->shifts.back().offsets;
    sound = sound && offsets.size() == joints &&
            std::all_of(offsets.begin(), offsets.end(), [](double x) { return std::isfinite(x); });
  }
  grasp->fingertips.ways.resize(3, message.fingertip_way_size());
  for (int i = 0; i < message.fingertip_way_size(); ++i) {
    grasp->fingertips.ways.col(i) = from_message(message.fingertip_way(i).way());
    grasp->fingertips.finger.push_back(message.fingertip_way(i).finger());
  }
  if (!sound) {
    throw geometry::InputError(
        "A grasp whose shifts have not one finite offset for each joint of its approach, and one "
        "way of the fingertips for each joint of the hand",
        "Look for the fault in the node that published it");
  }
}

}  // namespace

control::JointTrajectory from_message(const msgs::JointTrajectory& trajectory) {
  control::JointTrajectory path;
  path.joints.assign(trajectory.joint_name().begin(), trajectory.joint_name().end());
  for (const msgs::JointTrajectoryPoint& point : trajectory.points()) {
    path.points.push_back({point.time(),
                           {point.position().begin(), point.position().end()},
                           {point.velocity().begin(), point.velocity().end()},
                           {point.acceleration().begin(), point.acceleration().end()}});
  }
  return path;
}

msgs::JointTrajectory to_message(const control::JointTrajectory& path) {
  msgs::JointTrajectory trajectory;
  for (const std::string& name : path.joints) trajectory.add_joint_name(name);
  for (const control::JointTrajectory::Point& point : path.points) {
    msgs::JointTrajectoryPoint& out = *trajectory.add_points();
    out.set_time(point.time);
    for (const double value : point.position) out.add_position(value);
    for (const double value : point.velocity) out.add_velocity(value);
    for (const double value : point.acceleration) out.add_acceleration(value);
  }
  return trajectory;
}

bool has_arm_motion(const msgs::Grasp& grasp) {
  return grasp.arm_size() > 0 && grasp.hand_joint_name_size() > 0 &&
         grasp.open_position_size() == grasp.hand_joint_name_size() &&
         grasp.closed_position_size() == grasp.hand_joint_name_size();
}

control::ArmGrasp arm_grasp_from_message(const msgs::Grasp& grasp) {
  control::ArmGrasp result;
  // A parallel gripper that is turned by half is the same: its preshape tells nothing.
  const bool parallel = grasp.pregrasp_opening() > 0;
  result.pose = {from_message(grasp.x_wg()), parallel ? "" : grasp.preshape()};
  result.approach_length = grasp.pregrasp_distance();
  if (!std::isfinite(result.approach_length) || result.approach_length < 0) {
    throw geometry::InputError("A grasp whose pregrasp distance is no length",
                               "Look for the fault in the node that published it");
  }
  if (!(grasp.place_share() >= 0 && grasp.place_share() <= 1)) {
    throw geometry::InputError("A grasp whose place_share is no share",
                               "Look for the fault in the node that published it");
  }
  if (grasp.place_share() > 0) result.place_share = grasp.place_share();
  result.place_length = grasp.place_length();
  if (!std::isfinite(result.place_length) || result.place_length < 0) {
    throw geometry::InputError("A grasp whose place_length is no length",
                               "Look for the fault in the node that published it");
  }
  for (const msgs::ArmSegment& segment : grasp.arm()) {
    result.segments.emplace_back(from_message(segment.kind()), from_message(segment.trajectory()));
  }
  for (const msgs::JointTrajectory& view : grasp.held_view()) {
    result.views.push_back(view.points().empty() ? control::JointTrajectory{} : from_message(view));
  }
  result.views_problem = grasp.held_views_problem();
  result.hand_joints.assign(grasp.hand_joint_name().begin(), grasp.hand_joint_name().end());
  result.hand = closing_way_of(grasp);
  try {
    result.hand.validate();
  } catch (const std::invalid_argument& error) {
    throw geometry::InputError(
        std::string("A grasp of which the hand cannot close: ") + error.what(),
        "Look for the fault in the node that published it");
  }
  result.lifted_mass = grasp.predicted().lifted_mass();
  result.score = grasp.score();
  result.robustness = grasp.has_robustness() ? grasp.robustness() : -1;
  result.force = grasp.grasp_force();
  if (grasp.effort() > 0) result.effort = std::min(1.0, grasp.effort());
  result.largest_effort.assign(grasp.largest_effort().begin(), grasp.largest_effort().end());
  result.contact_area = grasp.predicted().contact_area();
  result.tactile_sum = grasp.predicted().tactile_sum();
  const Eigen::VectorXd stopped = vector_of(grasp.predicted().stop_position());
  if (stopped.size() == result.hand.closed.size()) result.closure = result.hand.closure(stopped);
  if (stopped.size() == result.hand.closed.size()) result.stops = stopped;
  const bool sound =
      (result.largest_effort.empty() ||
       result.largest_effort.size() == result.hand_joints.size()) &&
      std::all_of(result.largest_effort.begin(), result.largest_effort.end(),
                  [](double effort) { return std::isfinite(effort) && effort > 0; }) &&
      std::isfinite(result.force) && result.force >= 0 && std::isfinite(result.effort) &&
      (stopped.size() == 0 || stopped.size() == result.hand.closed.size()) &&
      std::isfinite(result.closure);
  add_shifts(grasp, &result);
  if (!sound) {
    throw geometry::InputError(
        "A grasp whose force, efforts or predicted stop are not numbers, one for each joint of "
        "the hand, the first two positive",
        "Look for the fault in the node that published it");
  }
  return result;
}

control::ArmGrasp probe_from_message(const msgs::Grasp& probe,
                                     const geometry::RigidTransform& X_HG) {
  control::ArmGrasp result = arm_grasp_from_message(probe);
  if (probe.contacts_size() != 1) {
    throw geometry::InputError("A probe without the place of its fingertip", kSenderMend);
  }
  const Eigen::Vector3d tip_H =
      X_HG * (result.pose.X_WG.inverse() * from_message(probe.contacts(0)));
  if (!tip_H.allFinite()) {
    throw geometry::InputError("A probe whose fingertip is nowhere", kSenderMend);
  }
  result.probe_H = tip_H;
  return result;
}

control::ArmGrasp push_from_message(const msgs::Grasp& push) {
  control::ArmGrasp result = arm_grasp_from_message(push);
  result.pushes = true;
  return result;
}

void add_motion(const control::ArmGrasp& grasp, msgs::Grasp* message) {
  for (const auto& [kind, path] : grasp.segments) {
    msgs::ArmSegment& segment = *message->add_arm();
    segment.set_kind(to_message(kind));
    *segment.mutable_trajectory() = to_message(path);
  }
  for (const control::JointTrajectory& view : grasp.views) {
    *message->add_held_view() = to_message(view);
  }
  message->set_held_views_problem(grasp.views_problem);
  if (grasp.place_share < 1) message->set_place_share(grasp.place_share);
  message->set_place_length(grasp.place_length);
  for (const std::string& name : grasp.hand_joints) message->add_hand_joint_name(name);
  for (const double position : grasp.hand.open) message->add_open_position(position);
  for (const double position : grasp.hand.closed) message->add_closed_position(position);
  for (const double rate : grasp.hand.rate) message->add_closing_rate(rate);
  for (const double position : grasp.hand.lower) message->add_least_position(position);
  for (const double position : grasp.hand.upper) message->add_largest_position(position);
  message->set_effort(grasp.effort);
  for (const double effort : grasp.largest_effort) message->add_largest_effort(effort);
  for (const control::HandShift& shift : grasp.shifts) {
    msgs::HandShift& added = *message->add_shift();
    *added.mutable_way() = to_message(shift.way_W);
    for (const double offset : shift.offsets) added.add_offset(offset);
  }
  for (std::size_t i = 0; i < grasp.fingertips.finger.size(); ++i) {
    msgs::FingertipWay& added = *message->add_fingertip_way();
    *added.mutable_way() =
        to_message(Eigen::Vector3d(grasp.fingertips.ways.col(static_cast<Eigen::Index>(i))));
    added.set_finger(grasp.fingertips.finger[i]);
  }
}

msgs::Surprise to_message(const control::Surprise& surprise, std::int64_t stamp) {
  msgs::Surprise message;
  message.mutable_header()->set_stamp(stamp);
  message.set_kind(to_message(surprise.kind));
  message.set_predicted(surprise.predicted);
  message.set_felt(surprise.felt);
  message.set_tolerance(surprise.tolerance);
  message.set_surprising(surprise.surprising);
  message.set_reaction(surprise.reaction);
  return message;
}

msgs::CycleResult to_message(const control::CycleResult& result, std::int64_t stamp) {
  msgs::CycleResult message;
  message.mutable_header()->set_stamp(stamp);
  message.set_outcome(to_message(result.outcome));
  message.set_reason(result.reason);
  message.set_grasp_index(static_cast<std::uint32_t>(result.grasp_index));
  message.set_attempts(static_cast<std::uint32_t>(result.attempts));
  message.set_touches(static_cast<std::uint32_t>(result.touches));
  message.set_looks(static_cast<std::uint32_t>(result.looks));
  message.set_pushes(static_cast<std::uint32_t>(result.pushes));
  message.set_placed(static_cast<std::uint32_t>(result.placed));
  return message;
}

msgs::CycleResult to_message(const control::Cycle& cycle, std::int64_t stamp) {
  msgs::CycleResult message = to_message(cycle.result(), stamp);
  for (const control::Surprise& surprise : cycle.surprises()) {
    *message.add_surprises() = to_message(surprise, stamp);
  }
  for (const auto& [phase, seconds] : cycle.phase_times()) {
    auto& time = *message.add_times();
    time.set_stage(phase);
    time.set_seconds(seconds);
  }
  for (const int state : cycle.path()) message.add_task_path(cycle.task().name_of(state));
  return message;
}

control::Advice advice_of(const msgs::GraspPlan& plan) {
  control::JointTrajectory look;
  if (plan.look().has_way()) look = from_message(plan.look().way());
  if (plan.choices_size() == 0) return {.look = std::move(look)};
  const msgs::Choice& best = plan.choices(0);
  if (best.act() == msgs::Choice::NOT_SAID || !msgs::Choice::Act_IsValid(best.act())) {
    throw geometry::InputError("A grasp plan with a choice that names no act", kSenderMend);
  }
  if (best.act() == msgs::Choice::TOUCH &&
      (best.grasp() < 0 || best.grasp() >= plan.grasps_size())) {
    throw geometry::InputError(fmt::format("A grasp plan that would touch with grasp {} of {}",
                                           best.grasp(), plan.grasps_size()),
                               kSenderMend);
  }
  return control::advice_of({static_cast<planning::Act>(best.act()), best.grasp(), best.success(),
                             best.worth(), best.text()},
                            look);
}

msgs::Task to_message(const control::Task& task, std::int64_t stamp) {
  msgs::Task message;
  message.mutable_header()->set_stamp(stamp);
  message.set_name(task.name);
  message.set_description(task.description);
  message.set_start(task.name_of(task.start));
  for (const control::TaskState& state : task.states) {
    msgs::Task::State& out = *message.add_states();
    out.set_name(state.name);
    out.set_action(to_message(state.action.primitive));
    for (const auto& [outcome, next] : state.next) {
      msgs::Task::Way& way = *out.add_ways();
      way.set_outcome(control::to_string(outcome));
      way.set_next(task.name_of(next));
    }
    out.set_times(static_cast<std::uint32_t>(state.times));
    if (state.times > 0) out.set_then(task.name_of(state.then));
  }
  return message;
}

}  // namespace prehend::convert
