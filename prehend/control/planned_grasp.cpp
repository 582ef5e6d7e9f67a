#include "prehend/control/planned_grasp.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace prehend::control {
namespace {

constexpr double kSamplePeriod = 0.02;  // s

std::vector<double> list_of(const Eigen::VectorXd& values) {
  return {values.begin(), values.end()};
}

JointTrajectory sampled(const robot::KinematicChain& chain,
                        const motion::BlendedTrajectory& trajectory) {
  JointTrajectory path;
  for (const robot::ChainJoint& joint : chain.joints()) path.joints.push_back(joint.name);
  const double duration = trajectory.duration();
  const int steps = std::max(1, static_cast<int>(std::ceil(duration / kSamplePeriod)));
  for (int i = 0; i <= steps; ++i) {
    const double time = duration * i / steps;
    const motion::TrajectoryPoint at = trajectory.at(time);
    path.points.push_back(
        {time, list_of(at.position), list_of(at.velocity), list_of(at.acceleration)});
    if (duration <= 0) break;
  }
  return path;
}

// Of what is planned like a grasp, a probe or a push.
template <class Planned>
std::optional<ArmGrasp> way_of(const robot::Platform& platform, const Planned& planned) {
  if (planned.segments.empty()) return std::nullopt;
  planning::PlannedPick pick;
  pick.grasp = planned.hand;
  pick.segments = planned.segments;
  return arm_grasp(platform, pick);
}

}  // namespace

ArmGrasp arm_grasp(const robot::Platform& platform, const planning::PlannedPick& pick) {
  const grasp::Grasp& grasp = pick.grasp;
  const robot::HandModel& hand = platform.hand;
  ArmGrasp result;
  result.pose = {grasp.X_WG, grasp.preshape};
  result.approach_length = grasp.pregrasp_distance;
  result.place_share = pick.place_share;
  const robot::KinematicChain chain = platform.arm_chain();
  for (const motion::PickSegment& segment : pick.segments) {
    result.segments.emplace_back(segment.kind, sampled(chain, *segment.trajectory));
    if (segment.kind == motion::SegmentKind::kPlace) {
      const auto tip = [&](double time) {
        return chain.forward(segment.trajectory->at(time).position).translation();
      };
      result.place_length = (tip(segment.trajectory->duration()) - tip(0)).norm();
    }
  }
  for (const std::string& name : hand.actuated_names()) {
    result.hand_joints.push_back("hand_" + name);
  }
  result.hand = robot::closing_way(hand, hand.preshape(grasp.preshape), grasp.open, grasp.closed);
  result.lifted_mass = grasp.predicted.lifted_mass;
  result.score = grasp.score;
  result.robustness = grasp.robustness;
  result.force = grasp.force;
  if (grasp.effort > 0) result.effort = std::min(1.0, grasp.effort);
  for (const int joint : hand.actuated) {
    result.largest_effort.push_back(hand.model.joints[static_cast<std::size_t>(joint)].max_effort);
  }
  result.contact_area = grasp.predicted.contact_area;
  result.tactile_sum = grasp.predicted.tactile_sum;
  if (pick.touch.stopped.size() == static_cast<Eigen::Index>(result.hand.closed.size())) {
    result.closure = result.hand.closure(pick.touch.stopped);
  }
  for (const planning::HeldView& view : pick.views.views) {
    result.views.push_back(view.trajectory ? sampled(chain, *view.trajectory) : JointTrajectory{});
  }
  result.views_problem = pick.views.problem;
  for (const planning::SidewaysShift& shift : pick.shifts) {
    result.shifts.push_back({shift.way_W, list_of(shift.offsets)});
  }
  // Where the planner alone thinks that it closes is too rough to tell a thing beside it.
  if (!result.shifts.empty() && pick.touch.stopped.size() == grasp.closed.size()) {
    const robot::Preshape& preshape = hand.preshape(grasp.preshape);
    const geometry::RigidTransform X_WH = grasp.X_WG * (hand.X_HP * preshape.X_PG).inverse();
    result.stops = pick.touch.stopped;
    result.fingertips = robot::fingertip_ways(hand, result.stops);
    result.fingertips.ways = (X_WH.linear() * result.fingertips.ways).eval();
  } else {
    result.shifts.clear();
  }
  return result;
}

std::optional<ArmGrasp> arm_probe(const robot::Platform& platform,
                                  const planning::PlannedProbe& probe) {
  std::optional<ArmGrasp> result = way_of(platform, probe);
  if (result) result->probe_H = probe.tip_H;
  return result;
}

std::optional<ArmGrasp> arm_push(const robot::Platform& platform,
                                 const planning::PlannedPush& push) {
  std::optional<ArmGrasp> result = way_of(platform, push);
  if (result) result->pushes = true;
  return result;
}

JointTrajectory look_way(const robot::Platform& platform, const planning::PlannedLook& look) {
  return look.found() ? sampled(platform.arm_chain(), *look.trajectory) : JointTrajectory{};
}

Advice advice_of(const robot::Platform& platform, const planning::PlatformPlan& plan) {
  JointTrajectory look = look_way(platform, plan.look);
  if (plan.choices.empty()) return {.look = std::move(look)};
  return advice_of(plan.choices.front(), look);
}

}  // namespace prehend::control
