#include "nodes/grasp_planning/platform_planning.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/grasp.h"
#include "nodes/task_source/task_source.h"
#include "prehend/robot/closing_way.h"

namespace prehend::nodes {
namespace {

constexpr double kSamplePeriod = 0.02;  // s, of trajectories in messages
constexpr double kAtHome = 1e-3;        // rad or m

}  // namespace

PlatformPlanning::PlatformPlanning(robot::Platform platform, const std::string& home,
                                   const planning::HandPlanOptions& grasps,
                                   planning::PlatformPickOptions arm, planning::PlaceOptions place,
                                   control::Task task, int motions)
    : platform_(std::move(platform)),
      home_(platform_.home(home).arm),
      start_(home_),
      hand_(platform_.hand),
      options_(planning::within_reach(grasps, platform_)),
      arm_options_(std::move(arm)),
      place_(std::move(place)),
      task_(std::move(task)),
      motions_(motions) {
  options_.pads.validate();
  options_.fingers.validate();
  place_.validate();
}

void PlatformPlanning::set_gripper(const robot::GripperModel& gripper) {
  platform_.set_gripper(gripper);
  hand_ = grasp::HandToClose(platform_.hand);
}

void PlatformPlanning::start_from(const msgs::JointState& joints) {
  const robot::KinematicChain chain = platform_.arm_chain();
  robot::Positions now = home_;
  for (int i = 0; i < chain.size(); ++i) {
    const std::string& name = chain.joints()[static_cast<std::size_t>(i)].name;
    const auto found = std::find(joints.name().begin(), joints.name().end(), name);
    const int k = static_cast<int>(found - joints.name().begin());
    if (k >= joints.position_size() || !std::isfinite(joints.position(k))) return;
    now[i] = joints.position(k);
  }
  start_ = (now - home_).cwiseAbs().maxCoeff() < kAtHome ? home_ : now;
}

msgs::Grasp PlatformPlanning::to_message(const planning::PlannedGrasp& grasp) const {
  msgs::Grasp message = grasp.pads ? convert::to_message(*grasp.pads) : msgs::Grasp();
  if (!grasp.pads) {
    *message.mutable_x_wg() = convert::to_message(grasp.pose.X_WG);
    *message.mutable_approach_direction() = convert::to_message(grasp.pose.approach_W);
    message.set_roll(grasp.roll);
    message.set_pregrasp_distance(grasp.pose.pregrasp_distance);
    message.set_grasp_force(grasp.force);
    message.set_quality(grasp.quality);
    message.set_score(grasp.score);
    if (grasp.robustness >= 0) message.set_robustness(grasp.robustness);
    message.set_generator(grasp.generator);
    message.set_guessed_contact(grasp.guessed_contact);
    message.set_remark(grasp.remark);
    *message.mutable_predicted() = convert::to_message(grasp.predicted);
  }
  message.set_preshape(grasp.pose.preshape);
  for (const std::string& name : platform_.hand.actuated_names()) {
    message.add_hand_joint_name("hand_" + name);
  }
  const robot::ClosingWay way = robot::closing_way(
      platform_.hand, platform_.hand.preshape(grasp.pose.preshape), grasp.pose.open, grasp.closed);
  for (const double position : way.open) message.add_open_position(position);
  for (const double position : way.closed) message.add_closed_position(position);
  for (const double rate : way.rate) message.add_closing_rate(rate);
  for (const double position : way.lower) message.add_least_position(position);
  for (const double position : way.upper) message.add_largest_position(position);
  message.set_effort(std::clamp(grasp.effort, 0.0, 1.0));
  for (const int joint : platform_.hand.actuated) {
    message.add_largest_effort(
        platform_.hand.model.joints[static_cast<std::size_t>(joint)].max_effort);
  }
  for (const Eigen::Vector3d& p_W : grasp.contacts_W) {
    *message.add_contacts() = convert::to_message(p_W);
  }
  return message;
}

msgs::ArmSegment PlatformPlanning::to_message(const motion::PickSegment& segment) const {
  msgs::ArmSegment message;
  message.set_name(segment.name);
  auto& trajectory = *message.mutable_trajectory();
  const robot::KinematicChain chain = platform_.arm_chain();
  for (const auto& joint : chain.joints()) trajectory.add_joint_name(joint.name);
  const double duration = segment.trajectory->duration();
  const int steps = std::max(1, static_cast<int>(std::ceil(duration / kSamplePeriod)));
  for (int i = 0; i <= steps; ++i) {
    const double time = duration * i / steps;
    const motion::TrajectoryPoint at = segment.trajectory->at(time);
    auto& point = *trajectory.add_points();
    point.set_time(time);
    for (const double value : at.position) point.add_position(value);
    for (const double value : at.velocity) point.add_velocity(value);
    for (const double value : at.acceleration) point.add_acceleration(value);
    if (duration <= 0) break;
  }
  return message;
}

msgs::GraspPlan PlatformPlanning::plan(const surface::ObjectModel& object,
                                       const geometry::Plane& table_W, const Neighbours& neighbours,
                                       const grasp::Reachability& reachability,
                                       grasp::GraspDatabase* database,
                                       const std::optional<grasp::PlacedObject>& known) const {
  grasp::Obstacles obstacles;
  obstacles.meshes_W = platform_.hand.gripper ? neighbours.meshes_W : neighbours.pieces_W;
  const planning::HandPlanResult plan = planning::plan_hand(
      hand_, object, table_W, obstacles, planning::within_reach(reachability, platform_), options_,
      database, known);
  msgs::GraspPlan message;
  message.set_candidates(static_cast<std::uint32_t>(plan.candidates));
  message.set_problem(plan.problem);
  convert::add_rejections(plan.rejections, &message);
  if (!plan.grasps.empty()) {
    add_motions(plan.grasps, {table_W, object.convex_pieces_W, neighbours.pieces_W}, &message);
  }
  return message;
}

// The grasps that the arm can execute, best first, and then the others; or why there is none.
void PlatformPlanning::add_motions(const std::vector<planning::PlannedGrasp>& grasps,
                                   const planning::PlatformScene& scene,
                                   msgs::GraspPlan* message) const {
  std::vector<Eigen::Vector3d> object;
  for (const auto& piece : scene.object_pieces_W) {
    object.insert(object.end(), piece.vertices.begin(), piece.vertices.end());
  }
  const planning::FreePlaces places =
      planning::free_places_for(platform_, scene, places_of(task_, object, place_));
  if (!places.problem.empty()) {
    message->set_problem("cannot be grasped: " + places.problem + ". " + planning::kPlaceMend);
    return;
  }
  planning::PlatformPickOptions options = arm_options_;
  options.moves_W = places.moves_W;
  std::vector<planning::PlannedGrasp> left = grasps;
  std::string arm_problem;
  for (int i = 0; i < motions_ && !left.empty(); ++i) {
    std::vector<planning::PlatformGrasp> poses;
    for (const auto& grasp : left) poses.push_back(grasp.pose);
    const planning::PlatformPick pick =
        planning::plan_platform_pick(platform_, start_, poses, scene, options);
    if (i == 0) {
      for (const auto& rejected : pick.motion.rejections) {
        auto& rejection = *message->add_rejections();
        rejection.set_reason(std::string("arm: ") + motion::to_string(rejected.filter));
        rejection.set_count(static_cast<std::uint32_t>(rejected.count));
        rejection.set_nearest_miss(rejected.nearest_miss);
      }
    }
    if (!pick.motion.found()) {
      arm_problem = pick.motion.problem;
      break;
    }
    msgs::Grasp grasp = to_message(left[static_cast<std::size_t>(pick.grasp)]);
    for (const auto& segment : pick.motion.segments) *grasp.add_arm() = to_message(segment);
    if (pick.motion.place >= 0) {
      *grasp.mutable_move() =
          convert::to_message(options.moves_W[static_cast<std::size_t>(pick.motion.place)]);
    }
    *message->add_grasps() = std::move(grasp);
    left.erase(left.begin() + pick.grasp);
  }
  if (message->grasps_size() == 0) {
    message->set_problem(fmt::format("cannot be grasped: the arm can execute none of {} grasps: {}",
                                     grasps.size(), arm_problem));
    return;
  }
  for (const auto& g : left) *message->add_grasps() = to_message(g);
}

}  // namespace prehend::nodes
