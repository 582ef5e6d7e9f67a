#include "eval/grasp/grasp_execution.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "prehend/control/pad_gripper.h"
#include "prehend/robot/closing_way.h"
#include "prehend/robot/platform.h"
#include "prehend/simulation/stage_arm.h"
#include "prehend/text/tree_file.h"

namespace prehend::eval {
namespace {

using control::MotionStatus;
using geometry::RigidTransform;
using motion::SegmentKind;
using simulation::GripperMode;
using simulation::World;

constexpr double kControlPeriod = 0.01;  // s
constexpr double kSettling = 0.5;        // s, after the end of the cycle
constexpr double kLookTimeout = 1;       // s
constexpr double kTransitHeight = 0.3;   // m, of the gripper's frame, where it crosses the scene
constexpr double kLiftHeight = 0.15;     // m
constexpr double kAside = 0.15;          // m, along y, with the object
constexpr double kFast = 0.25, kSlow = 0.08, kLiftSpeed = 0.1;  // m/s, on average
constexpr double kTurnRate = 0.7;                               // rad/s, on average

class SimulatedGripper : public control::GripperPort {
 public:
  explicit SimulatedGripper(World& world) : world_(world) {}
  void move_to(double opening, double speed) override {
    target_ = opening;
    world_.set_gripper_command(GripperMode::kPosition, opening, 0, speed);
  }
  MotionStatus motion() override {
    const auto reading = world_.gripper();
    if (std::abs(reading.opening - target_) < 1e-3) return MotionStatus::kReached;
    return reading.blocked ? MotionStatus::kContact : MotionStatus::kMoving;
  }
  void command_velocity(double speed, double current_limit) override {
    world_.set_gripper_command(GripperMode::kVelocity, speed, current_limit);
  }
  void stop() override { world_.set_gripper_command(GripperMode::kStop, 0); }

 private:
  World& world_;
  double target_ = 0;
};

/// The stage with its way round grasps.
class SimulatedStage : public control::ArmPort {
 public:
  explicit SimulatedStage(World& world)
      : world_(world),
        platform_(robot::read_platform(text::tree_file("config/robots/stage_pg70.yaml"))),
        arm_(platform_, "home") {
    platform_.set_gripper(world.scene().gripper);
  }
  void follow(const control::JointTrajectory& path, double contact_force) override {
    simulation::TrajectoryRequest request{path.joints, {}};
    for (const auto& point : path.points) {
      request.points.push_back({point.time, point.position, point.velocity, point.acceleration});
    }
    problem_.clear();
    try {
      arm_.follow(request, {}, world_);
      arm_.stop_on_contact(contact_force);
    } catch (const std::invalid_argument& error) {
      problem_ = error.what();
    }
  }
  MotionStatus motion() override {
    using Status = simulation::ArmDrive::Status;
    if (!problem_.empty()) return MotionStatus::kFailed;
    if (arm_.drive().status() == Status::kReached) return MotionStatus::kReached;
    if (arm_.drive().status() == Status::kMoving || arm_.moves()) return MotionStatus::kMoving;
    return arm_.stopped_by_contact() ? MotionStatus::kContact : MotionStatus::kFailed;
  }
  std::string problem() override { return problem_.empty() ? arm_.drive().reason() : problem_; }
  void stop() override { arm_.stop(); }

  void step() {
    arm_.begin_step(world_);
    world_.step();
    arm_.end_step(world_);
  }
  std::vector<std::string> joint_names() const {
    std::vector<std::string> names;
    for (const auto& joint : arm_.drive().chain().joints()) names.push_back(joint.name);
    return names;
  }

  /// Grasps with the stage's way from where it stands.
  std::vector<control::ArmGrasp> with_ways(const std::vector<grasp::Grasp>& grasps) const {
    std::vector<control::ArmGrasp> result;
    for (const grasp::Grasp& grasp : grasps) result.push_back(with_way(grasp));
    return result;
  }

 private:
  control::ArmGrasp with_way(const grasp::Grasp& grasp) const {
    control::ArmGrasp result;
    result.pose.X_WG = grasp.X_WG;
    robot::Positions here = simulation::stage_position(world_);
    robot::Positions at(4);
    const double turn = std::atan2(grasp.X_WG(1, 0), grasp.X_WG(0, 0));
    at << grasp.X_WG.translation(), here[3] + std::remainder(turn - here[3], 2 * M_PI);
    const double most = arm_.drive().chain().joints()[3].upper;
    if (std::abs(at[3]) > most) at[3] = std::remainder(at[3], 2 * M_PI);
    const auto moved = [](robot::Positions q, const Eigen::Vector3d& by) {
      q.head<3>() += by;
      return q;
    };
    const auto raised = [](robot::Positions q) {
      q[2] = std::max(q[2], kTransitHeight);
      return q;
    };
    const auto add = [&](SegmentKind kind, const std::vector<robot::Positions>& over,
                         double speed) {
      control::JointTrajectory path{joint_names(), {}};
      double time = 0;
      const std::vector<double> rest(4, 0.0);
      path.points.push_back({0, {here.begin(), here.end()}, rest, rest});
      for (const robot::Positions& next : over) {
        const double seconds = std::max((next - here).head<3>().norm() / speed,
                                        std::abs(next[3] - here[3]) / kTurnRate);
        // At rest in each corner: peaks are 1.9 times the mean speed, 5.8 times way over time^2.
        time += std::max({seconds, std::sqrt(5.8 * (next - here).cwiseAbs().maxCoeff()), 0.02});
        path.points.push_back({time, {next.begin(), next.end()}, rest, rest});
        here = next;
      }
      result.segments.emplace_back(kind, std::move(path));
    };
    const Eigen::Vector3d up(0, 0, kLiftHeight), aside(0, kAside, 0);
    const Eigen::Vector3d back = -grasp.pregrasp_distance * grasp.approach_W;
    const robot::Positions before = moved(at, back), there = moved(at, aside);
    add(SegmentKind::kReach, {raised(here), raised(before), before}, kFast);
    add(SegmentKind::kApproach, {at}, kSlow);
    add(SegmentKind::kLift, {moved(at, up)}, kLiftSpeed);
    add(SegmentKind::kCarry, {moved(there, up)}, kFast);
    add(SegmentKind::kPlace, {there}, kSlow);
    add(SegmentKind::kRetreat, {moved(there, back)}, kFast);
    result.hand_joints = {"hand_opening"};
    const auto joints = [](double opening) {
      return Eigen::VectorXd(Eigen::VectorXd::Constant(1, opening / 2));
    };
    result.hand = robot::closing_way(
        platform_.hand, platform_.hand.preshapes.front(),
        joints(std::min(pregrasp_opening(grasp), platform_.hand.gripper->max_opening)),
        joints(grasp.predicted.opening));
    result.lifted_mass = grasp.predicted.lifted_mass;
    result.score = grasp.score;
    result.robustness = grasp.robustness;
    result.force = grasp.force;
    result.contact_area = grasp.predicted.contact_area;
    result.tactile_sum = grasp.predicted.tactile_sum;
    return result;
  }

  World& world_;
  robot::Platform platform_;
  simulation::StageArm arm_;
  std::string problem_;
};

control::PadPercept pad_percept(const World& world, simulation::PadSide side) {
  const auto image = world.tactile_image(side);
  const auto& pad = world.scene().gripper.pad;
  const auto touched = std::count_if(image.counts.begin(), image.counts.end(),
                                     [](std::uint16_t count) { return count > 10; });
  return {image.sum, static_cast<double>(touched) * pad.texel_pitch * pad.texel_pitch, 0,
          side == simulation::PadSide::kLeft ? "left" : "right"};
}

control::ArmPercepts perceive(const World& world, const std::vector<std::string>& joints) {
  control::ArmPercepts percepts;
  percepts.time = world.time();
  percepts.names = joints;
  const robot::Positions q = simulation::stage_position(world);
  percepts.positions.assign(q.begin(), q.end());
  percepts.wrist_force = world.wrist_wrench().force;
  percepts.pads = {pad_percept(world, simulation::PadSide::kLeft),
                   pad_percept(world, simulation::PadSide::kRight)};
  percepts.gripper = {world.gripper().opening, world.gripper().blocked, 0, 0};
  return percepts;
}

}  // namespace

GraspExecution execute_grasps(World& world, std::size_t object, const grasp::GraspPlan& plan,
                              double time_limit, const LookAgain& look_again) {
  const auto start = world.body(object);
  const double start_time = world.time(), step = world.scene().step;
  SimulatedGripper gripper(world);
  SimulatedStage stage(world);
  control::PadGripper hand(world.scene().gripper, {}, gripper);
  control::ArmCycleOptions options;
  options.reacts = true;
  options.look_timeout = look_again ? kLookTimeout : 0;
  control::ArmCycle cycle(options, stage, hand);
  std::vector<grasp::Grasp> grasps = plan.grasps;
  const std::vector<std::string> joints = stage.joint_names();
  cycle.start(stage.with_ways(grasps), grasp::in_words(plan));

  GraspExecution execution;
  int attempts = 0;
  std::optional<Eigen::Vector3d> p_GB;  // of the object in the hand when the lift starts
  const auto steps_per_tick = std::max(1L, std::lround(kControlPeriod / step));
  for (long i = 0; world.time() - start_time < time_limit && !cycle.finished(); ++i) {
    stage.step();
    const auto body = world.body(object);
    execution.raised = std::max(execution.raised, body.height - start.height);
    if (i % steps_per_tick != 0) continue;
    cycle.step(perceive(world, joints));
    const RigidTransform X_moved = body.X_WB * start.X_WB.inverse();
    if (cycle.looks_since()) {
      auto plan_now = look_again(X_moved);
      cycle.take_plan(stage.with_ways(plan_now.grasps), grasp::in_words(plan_now));
      if (!plan_now.grasps.empty()) grasps = std::move(plan_now.grasps);
    }
    if (std::exchange(attempts, cycle.result().attempts) != cycle.result().attempts) {
      execution.X_moved = X_moved;
    }
    const control::Phase phase = cycle.phase();
    if (phase == control::Phase::kLift || phase == control::Phase::kMove) {
      const Eigen::Vector3d now = (world.carrier().X_WG.inverse() * body.X_WB).translation();
      if (!p_GB) p_GB = now;
      execution.slip = (now - *p_GB).norm();
    } else if (phase == control::Phase::kApproach || phase == control::Phase::kGrasp) {
      p_GB.reset();  // another attempt
    }
  }
  if (!cycle.finished()) cycle.abort("the time was used up");
  for (double settled = 0; settled < kSettling; settled += step) stage.step();
  const auto end = world.body(object);
  execution.result = cycle.result();
  if (attempts > 0) execution.grasp = grasps.at(static_cast<std::size_t>(cycle.grasp_index()));
  execution.surprises = cycle.surprises();
  execution.phase_times = cycle.phase_times();
  execution.moved = (end.X_WB.translation() - start.X_WB.translation()).head<2>().norm();
  execution.final_height = end.height;
  execution.seconds = world.time() - start_time;
  return execution;
}

}  // namespace prehend::eval
