#include "eval/grasp/grasp_execution.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace prehend::eval {
namespace {

using control::MotionStatus;
using geometry::RigidTransform;
using simulation::GripperMode;
using simulation::World;

constexpr double kControlPeriod = 0.01;  // s
constexpr double kSettling = 0.5;        // s, after the end of the cycle
constexpr double kLookTimeout = 1;       // s

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

class SimulatedCarrier : public control::CarrierPort {
 public:
  explicit SimulatedCarrier(World& world) : world_(world) {}
  void move_to(const RigidTransform& X_WG, double speed, double contact_force) override {
    contact_force_ = contact_force;
    contact_ = false;
    world_.move_carrier(X_WG, speed);
  }
  MotionStatus motion() override {
    if (contact_) return MotionStatus::kContact;
    return world_.carrier().moving ? MotionStatus::kMoving : MotionStatus::kReached;
  }
  void stop() override { world_.stop_carrier(); }
  // What a driver would do in every cycle of its loop.
  void watch() {
    if (contact_force_ > 0 && world_.wrist_wrench().force.norm() > contact_force_) {
      world_.stop_carrier();
      contact_force_ = 0;
      contact_ = true;
    }
  }

 private:
  World& world_;
  double contact_force_ = 0;
  bool contact_ = false;
};

control::PadPercept pad_percept(const World& world, simulation::PadSide side) {
  const auto image = world.tactile_image(side);
  const auto& pad = world.scene().gripper.pad;
  const auto touched = std::count_if(image.counts.begin(), image.counts.end(),
                                     [](std::uint16_t count) { return count > 10; });
  return {image.sum, static_cast<double>(touched) * pad.texel_pitch * pad.texel_pitch};
}

control::Percepts perceive(const World& world) {
  control::Percepts percepts;
  percepts.time = world.time();
  percepts.left = pad_percept(world, simulation::PadSide::kLeft);
  percepts.right = pad_percept(world, simulation::PadSide::kRight);
  percepts.opening = world.gripper().opening;
  percepts.gripper_blocked = world.gripper().blocked;
  percepts.wrist_force = world.wrist_wrench().force.norm();
  percepts.X_WG = world.carrier().X_WG;
  return percepts;
}

}  // namespace

GraspExecution execute_grasps(World& world, std::size_t object, const grasp::GraspPlanResult& plan,
                              control::CycleOptions options, double time_limit,
                              const LookAgain& look_again) {
  const auto start = world.body(object);
  const double start_time = world.time(), step = world.scene().step;
  SimulatedGripper gripper(world);
  SimulatedCarrier carrier(world);
  options.look_timeout = look_again ? kLookTimeout : 0;
  control::GraspCycle cycle(world.scene().gripper, options, gripper, carrier);
  cycle.start(plan.grasps, plan.problem);

  GraspExecution execution;
  int attempts = 0;
  std::optional<Eigen::Vector3d> p_GB;  // of the object in the hand when the lift starts
  const auto steps_per_tick = std::max(1L, std::lround(kControlPeriod / step));
  for (long i = 0; world.time() - start_time < time_limit && !cycle.finished(); ++i) {
    world.step();
    carrier.watch();
    const auto body = world.body(object);
    execution.raised = std::max(execution.raised, body.height - start.height);
    if (i % steps_per_tick != 0) continue;
    cycle.step(perceive(world));
    const RigidTransform X_moved = body.X_WB * start.X_WB.inverse();
    if (cycle.looks_since()) {
      auto plan_now = look_again(X_moved);
      cycle.take_plan(std::move(plan_now.grasps), options.move_W, plan_now.problem);
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
  for (double settled = 0; settled < kSettling; settled += step) world.step();
  const auto end = world.body(object);
  execution.result = cycle.result();
  if (attempts > 0) execution.grasp = cycle.grasp();
  execution.surprises = cycle.surprises();
  execution.phase_times = cycle.phase_times();
  execution.moved = (end.X_WB.translation() - start.X_WB.translation()).head<2>().norm();
  execution.final_height = end.height;
  execution.seconds = world.time() - start_time;
  return execution;
}

}  // namespace prehend::eval
