#include "nodes/simulation/simulated_robot.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace prehend::nodes {

using simulation::GripperMode;
using simulation::PadSide;

namespace {

int steps_of_slice(const simulation::Scene& scene) {
  return std::max(1, static_cast<int>(std::lround(SimulatedRobot::kSlice / scene.step)));
}

}  // namespace

std::int64_t SimulatedRobot::slice_of(const simulation::Scene& scene) {
  return std::llround(steps_of_slice(scene) * scene.step * 1e9);
}

SimulatedRobot::SimulatedRobot(graph::Node& node, const simulation::Scene& scene,
                               const robot::Platform& platform, const std::string& home,
                               graph::ClockPacer& pacer,
                               std::function<void(const SensorReadings&)> on_readings,
                               std::function<void(std::int64_t)> on_pace)
    : node_(node),
      world_(scene),
      arm_(platform, home),
      on_readings_(std::move(on_readings)),
      loop_(
          node, pacer, slice_of(scene), [this] { slice(); }, [this] { on_readings_(readings_); },
          std::move(on_pace)) {}

void SimulatedRobot::slice() {
  bool watchdog_fired = false, arm_stopped = false;
  {
    const std::lock_guard lock(mutex_);
    step_slice();
    if (arm_commanded_ && world_.time() - arm_command_time_ > kWatchdog) {
      arm_stopped = !arm_.drive().is_idle();
      arm_.stop();
      arm_commanded_ = false;
    }
    readings_ = read();
    ++slices_;
    watchdog_fired = std::exchange(watchdog_fired_, false);
  }
  slice_done_.notify_all();
  if (watchdog_fired)
    node_.log_warning("no gripper command for {} s while moving: stopped", kWatchdog);
  if (arm_stopped) node_.log_warning("no arm command for {} s while moving: stopped", kWatchdog);
}

void SimulatedRobot::step_slice() {
  for (std::int64_t left = steps_of_slice(world_.scene()); left > 0;) {
    std::int64_t until_watchdog = left;
    if (continuous_command_) {
      const double spent = world_.time() - command_time_;
      const double steps = std::floor((kWatchdog - spent) / world_.scene().step) + 1;
      until_watchdog = std::clamp<std::int64_t>(static_cast<std::int64_t>(steps), 1, left);
    }
    left -= arm_.advance(world_, until_watchdog);
    if (continuous_command_ && world_.time() - command_time_ > kWatchdog &&
        world_.gripper().moving) {
      world_.set_gripper_command(GripperMode::kStop, 0);
      continuous_command_ = false;
      watchdog_fired_ = true;
    }
  }
}

SensorReadings SimulatedRobot::read() const {
  SensorReadings readings;
  readings.stamp = std::llround(world_.time() * 1e9);
  readings.gripper = world_.gripper();
  readings.gripper_error = gripper_error_;
  const simulation::CarrierReading carrier = world_.carrier();
  const robot::Positions q = simulation::stage_position(world_);
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double velocity = i < 3 ? carrier.velocity[i] : carrier.yaw_rate;
    const auto& joint = arm_.drive().chain().joints()[static_cast<std::size_t>(i)];
    readings.joints.push_back({joint.name, q[i], velocity, 0});
  }
  readings.wrench = world_.wrist_wrench();
  readings.has_frames = slices_ % 2 == 0;
  if (!readings.has_frames) return readings;
  if (world_.has_touch()) {
    readings.left = world_.tactile_image(PadSide::kLeft);
    readings.right = world_.tactile_image(PadSide::kRight);
  }
  for (std::size_t i = 0; i < world_.body_count(); ++i) readings.bodies.push_back(world_.body(i));
  return readings;
}

void SimulatedRobot::check_gripper() const {
  if (gripper_error_ == 0) return;
  throw std::invalid_argument("the gripper was stopped by a fast stop; acknowledge it first");
}

void SimulatedRobot::command_gripper(GripperMode mode, double value, double current_limit,
                                     std::int64_t stamp) {
  const std::lock_guard lock(mutex_);
  if (stamp != 0 && stamp <= action_stamp_) return;
  if (mode != GripperMode::kStop) check_gripper();
  world_.set_gripper_command(mode, value, current_limit);
  ++gripper_ticket_;
  gripper_taker_ = mode == GripperMode::kStop ? "stopped by /gripper/command"
                                              : "another command took the gripper over";
  continuous_command_ = mode != GripperMode::kStop;
  command_time_ = world_.time();
}

std::uint64_t SimulatedRobot::move_gripper(double opening, double speed, double current_limit,
                                           std::int64_t stamp) {
  const std::lock_guard lock(mutex_);
  check_gripper();
  action_stamp_ = stamp;
  world_.set_gripper_command(GripperMode::kPosition, opening, current_limit, speed);
  continuous_command_ = false;
  gripper_taker_ = "another command took the gripper over";
  return ++gripper_ticket_;
}

std::string SimulatedRobot::loss_of_gripper(std::uint64_t ticket) {
  const std::lock_guard lock(mutex_);
  return ticket == gripper_ticket_ ? std::string() : gripper_taker_;
}

void SimulatedRobot::stop_gripper(const std::string& why) {
  const std::lock_guard lock(mutex_);
  world_.set_gripper_command(GripperMode::kStop, 0);
  ++gripper_ticket_;
  gripper_taker_ = why;
  continuous_command_ = false;
}

void SimulatedRobot::fast_stop_gripper(const std::string& why) {
  constexpr std::uint32_t kFastStop = 0xD9;
  stop_gripper(why);
  const std::lock_guard lock(mutex_);
  gripper_error_ = kFastStop;
}

bool SimulatedRobot::acknowledge_gripper() {
  const std::lock_guard lock(mutex_);
  return std::exchange(gripper_error_, 0u) != 0;
}

std::uint64_t SimulatedRobot::take_arm() {
  const std::lock_guard lock(mutex_);
  arm_commanded_ = false;
  return ++arm_ticket_;
}

bool SimulatedRobot::holds_arm(std::uint64_t ticket) {
  const std::lock_guard lock(mutex_);
  return ticket == arm_ticket_;
}

void SimulatedRobot::stop_arm(std::uint64_t ticket) {
  const std::lock_guard lock(mutex_);
  if (ticket != arm_ticket_) return;
  if (arm_.moves()) arm_.stop();
}

void SimulatedRobot::follow(const simulation::TrajectoryRequest& request,
                            const std::vector<double>& tolerance, double contact_force) {
  const std::lock_guard lock(mutex_);
  arm_commanded_ = false;
  try {
    arm_.follow(request, tolerance, world_);
  } catch (const std::invalid_argument&) {
    arm_.let_go();
    throw;
  }
  arm_.stop_on_contact(contact_force);
}

bool SimulatedRobot::command_arm(const std::vector<std::string>& joints,
                                 const std::vector<double>& positions) {
  const std::lock_guard lock(mutex_);
  if (joints.empty()) {
    if (arm_.moves()) arm_.stop();
    ++arm_ticket_;
    arm_commanded_ = false;
    return false;
  }
  const robot::Positions goal =
      simulation::check_set_point(arm_.drive().chain(), joints, positions);
  arm_.track(goal, world_);
  arm_command_time_ = world_.time();
  if (std::exchange(arm_commanded_, true)) return false;
  ++arm_ticket_;
  return true;
}

MovedArm::State SimulatedRobot::arm_state() {
  const std::lock_guard lock(mutex_);
  const simulation::ArmDrive& drive = arm_.drive();
  return {drive.status(),
          !world_.carrier().moving,
          arm_.stopped_by_contact(),
          drive.time(),
          drive.largest_error(),
          drive.desired(),
          simulation::stage_position(world_),
          drive.reason()};
}

void SimulatedRobot::wait_for_slice() {
  std::unique_lock lock(mutex_);
  const std::uint64_t before = slices_;
  slice_done_.wait_for(lock, std::chrono::milliseconds(100), [&] { return slices_ != before; });
}

}  // namespace prehend::nodes
