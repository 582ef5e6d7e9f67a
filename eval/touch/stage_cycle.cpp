#include "eval/touch/stage_cycle.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "prehend/control/cycle_in_world.h"
#include "prehend/control/stage_in_world.h"
#include "prehend/robot/closing_way.h"
#include "prehend/text/require.h"
#include "prehend/text/tree_file.h"

namespace prehend::eval::touch {
namespace {

using control::JointTrajectory;
using control::Phase;
using simulation::PadSide;

const Eigen::Vector3d kBoxSize(0.05, 0.05, 0.07);  // m
constexpr double kBoxMass = 0.3;                   // kg
constexpr double kRaise = 0.1;                     // m
constexpr double kAboveGrasp = 0.12;               // m, where the approach begins
constexpr double kStageSpeed = 0.1;                // m/s, mean, of the stage
constexpr double kNearlyNone = 1e-3;               // N, of friction
constexpr double kJumpTime = 0.0201;               // s
constexpr double kSettledShare = 0.02;             // of the force

simulation::Scene scene_of(const robot::Platform& platform, const StageCycleOptions& options) {
  simulation::Scene scene;
  scene.gripper = *platform.hand.gripper;
  if (options.stiffness > 0) scene.gripper.pad.law.stiffness = options.stiffness;
  scene.carrier = simulation::carrier_of(platform, "side");
  if (!options.stuck_drive) scene.gripper.friction_force = kNearlyNone;
  scene.drive = simulation::drive_of(scene.gripper, simulation::pg70_drive());
  if (options.stuck_drive) {
    scene.drive.static_friction += kHiddenStiction;
    scene.drive.coulomb_friction += kHiddenStiction;
  } else {
    scene.drive.static_friction = scene.drive.coulomb_friction = scene.drive.viscous_friction = 0;
  }
  if (options.realistic_pads) {
    const auto ideal = scene.tactile.sensor;
    scene.tactile.sensor = simulation::TactileSensorOptions::realistic();
    scene.tactile.sensor.threshold = ideal.threshold;
    scene.tactile.foam = contact::FoamMemory::realistic();
  }
  simulation::SceneObject box;
  box.name = "box";
  box.size = kBoxSize;
  box.mass = kBoxMass;
  scene.objects = {box};
  return scene;
}

control::ArmGrasp grasp_of(const robot::Platform& platform, const StageCycleOptions& options) {
  const robot::GripperModel& gripper = *platform.hand.gripper;
  const double pad_length = gripper.pad.length();
  const double z = kBoxSize.z() - options.coverage * pad_length + pad_length / 2;
  const robot::Positions side = platform.home("side").arm;
  const std::vector<double> home(side.begin(), side.end()), above{0, 0, z + kAboveGrasp, 0},
      there{0, 0, z, 0}, lifted{0, 0, z + kRaise, 0};
  control::ArmGrasp grasp;
  using motion::SegmentKind;
  grasp.segments = {{SegmentKind::kReach, stage_way(home, above)},
                    {SegmentKind::kApproach, stage_way(above, there)},
                    {SegmentKind::kLift, stage_way(there, lifted)}};
  grasp.hand_joints = {"hand_opening"};
  const auto one = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  grasp.hand = {one(gripper.max_opening / 2), one(kBoxSize.y() / 2), one(-robot::kJawLever), one(0),
                one(gripper.max_opening / 2)};
  grasp.force = options.grip_force;
  grasp.score = 1;
  return grasp;
}

std::vector<double> counts_of(const simulation::TactileImage& image) {
  return {image.counts.begin(), image.counts.end()};
}

// Of what happened between the touch and the lift.
void measure(double force, StageCycle* cycle) {
  std::optional<double> settled;
  const StageCycleSample* before = nullptr;  // the last one of velocity control
  const StageCycleSample* last = nullptr;
  for (const StageCycleSample& sample : cycle->samples) {
    if (sample.time > cycle->lift_time) break;
    if (last) {
      cycle->rise =
          std::max(cycle->rise, (sample.mean() - last->mean()) / (sample.time - last->time));
    }
    last = &sample;
    if (sample.time < cycle->touch_time) {
      before = &sample;
      continue;
    }
    const bool within = std::abs(sample.mean() - force) <= kSettledShare * force;
    if (!within) settled.reset();
    if (within && !settled) settled = sample.time;
    if (before && sample.time <= cycle->touch_time + kJumpTime) {
      cycle->jump = sample.mean() - before->mean();
    }
    cycle->held_left = sample.left;
    cycle->held_right = sample.right;
  }
  cycle->settled_after = settled.value_or(cycle->lift_time) - cycle->touch_time;
}

}  // namespace

JointTrajectory stage_way(const std::vector<double>& from, const std::vector<double>& to) {
  constexpr int kPoints = 60;
  double length = 0;
  for (std::size_t k = 0; k < from.size(); ++k) length += (to[k] - from[k]) * (to[k] - from[k]);
  const double duration = std::max(0.5, std::sqrt(length) / kStageSpeed);
  JointTrajectory path{{"arm_x", "arm_y", "arm_z", "arm_yaw"}, {}};
  for (int i = 0; i <= kPoints; ++i) {
    const double t = static_cast<double>(i) / kPoints;
    const double s = t * t * t * (10 + t * (6 * t - 15));
    const double rate = 30 * t * t * (1 - t) * (1 - t) / duration;
    JointTrajectory::Point point{t * duration, {}, {}, {}};
    for (std::size_t k = 0; k < from.size(); ++k) {
      point.position.push_back(from[k] + s * (to[k] - from[k]));
      point.velocity.push_back(rate * (to[k] - from[k]));
    }
    path.points.push_back(std::move(point));
  }
  return path;
}

StageCycle run_stage_cycle(const StageCycleOptions& options) {
  const text::Require require{"StageCycleOptions."};
  require(options.coverage > 0 && options.coverage <= 1, "coverage must be above 0, at most 1");
  require(std::isfinite(options.grip_force) && options.grip_force > 0,
          "grip_force must be positive");
  require(std::isfinite(options.stiffness) && options.stiffness >= 0,
          "stiffness must not be negative");
  robot::Platform platform = robot::read_platform(text::tree_file("config/robots/stage_pg70.yaml"));
  const simulation::Scene scene = scene_of(platform, options);
  platform.hand.gripper = scene.gripper;  // as its driver would say it is
  simulation::World world(scene);
  control::StageInWorld stage(world, platform, "side");
  control::ArmCycleOptions cycle_options;
  cycle_options.task = control::read_task(text::tree_file("config/tasks/work_cycle.yaml"));
  cycle_options.largest_attempts = 1;
  control::CycleInWorld run(stage, cycle_options);
  StageCycle trace;
  Phase last = Phase::kWaiting;
  PadImages images;
  const auto watch = [&] {
    const control::ArmCycle& cycle = run.cycle();
    StageCycleSample sample{
        world.time(), cycle.phase(), 0, 0, world.gripper().opening, world.body("box").height};
    for (const robot::PadPercept& pad : stage.percepts(robot::kTouchCounts).pads) {
      (pad.name == "left" ? sample.left : sample.right) = pad.sum;
    }
    if (sample.phase != last) trace.images[last] = images;
    if (sample.phase == Phase::kLift && last != Phase::kLift) trace.lift_time = sample.time;
    last = sample.phase;
    images = {counts_of(world.tactile_image(PadSide::kLeft)),
              counts_of(world.tactile_image(PadSide::kRight))};
    const auto& surprises = cycle.surprises();
    const bool touched = std::any_of(surprises.begin(), surprises.end(), [](const auto& surprise) {
      return surprise.kind == control::SurpriseKind::kOpeningAtContact;
    });
    if (touched && trace.touch_time == 0) trace.touch_time = sample.time;
    trace.raised = std::max(trace.raised, sample.height);
    trace.samples.push_back(sample);
  };
  trace.result = run.run({{grasp_of(platform, options)}, ""}, nullptr, watch);
  trace.images[last] = images;
  measure(options.grip_force, &trace);
  return trace;
}

}  // namespace prehend::eval::touch
