#include "nodes/simulation/robot_runner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace prehend::nodes {

RobotRunner::RobotRunner(graph::Node& node, simulation::RobotWorld world, graph::ClockPacer& pacer,
                         std::int64_t slice, std::function<void(const RobotReadings&)> on_readings,
                         std::function<void(std::int64_t)> on_pace)
    : node_(node),
      world_(std::move(world)),
      steps_(std::max(1, static_cast<int>(std::lround(static_cast<double>(slice) * 1e-9 /
                                                      world_.options().step)))),
      on_readings_(std::move(on_readings)),
      loop_(
          node, pacer, slice, [this] { this->slice(); }, [this] { on_readings_(readings_); },
          std::move(on_pace)) {}

void RobotRunner::slice() {
  bool watchdog_fired = false, arm_stopped = false;
  {
    const std::lock_guard lock(mutex_);
    for (int i = 0; i < steps_; ++i) {
      world_.step();
      if (hand_commanded_ && world_.time() - command_time_ > kWatchdog) {
        watchdog_fired = world_.stop_commanded_hand() || watchdog_fired;
      }
      if (arm_commanded_ && world_.time() - arm_command_time_ > kWatchdog) {
        arm_stopped = !world_.arm().is_idle();
        world_.arm().stop();
        arm_commanded_ = false;
      }
    }
    readings_ = read();
    ++slices_;
  }
  slice_done_.notify_all();
  if (watchdog_fired)
    node_.log_warning("no hand command for {} s while moving: stopped", kWatchdog);
  if (arm_stopped) node_.log_warning("no arm command for {} s while moving: stopped", kWatchdog);
}

RobotReadings RobotRunner::read() const {
  RobotReadings readings;
  readings.stamp = std::llround(world_.time() * 1e9);
  readings.joints = world_.joints();
  readings.wrench = world_.wrist_wrench();
  readings.has_frames = slices_ % 2 == 0;
  if (!readings.has_frames) return readings;
  readings.pads = world_.pads();
  for (std::size_t i = 0; i < world_.body_count(); ++i) readings.bodies.push_back(world_.body(i));
  return readings;
}

std::uint64_t RobotRunner::take_arm() {
  const std::lock_guard lock(mutex_);
  arm_commanded_ = false;
  return ++arm_ticket_;
}

bool RobotRunner::holds_arm(std::uint64_t ticket) {
  const std::lock_guard lock(mutex_);
  return ticket == arm_ticket_;
}

void RobotRunner::stop_arm(std::uint64_t ticket) {
  const std::lock_guard lock(mutex_);
  if (ticket == arm_ticket_) world_.arm().stop();
}

void RobotRunner::follow(const simulation::TrajectoryRequest& request,
                         const std::vector<double>& tolerance, double contact_force) {
  const std::lock_guard lock(mutex_);
  arm_commanded_ = false;
  try {
    world_.follow(request, tolerance);
  } catch (const std::invalid_argument&) {
    world_.arm().forget();
    throw;
  }
  if (contact_force > 0) world_.stop_on_contact(contact_force);
}

bool RobotRunner::command_arm(const std::vector<std::string>& joints,
                              const std::vector<double>& positions) {
  const std::lock_guard lock(mutex_);
  if (joints.empty()) {
    world_.arm().stop();
    ++arm_ticket_;
    arm_commanded_ = false;
    return false;
  }
  const robot::Positions goal =
      simulation::check_set_point(world_.arm().chain(), joints, positions);
  world_.arm().track(goal);
  arm_command_time_ = world_.time();
  if (std::exchange(arm_commanded_, true)) return false;
  world_.stop_on_contact(0);
  ++arm_ticket_;
  return true;
}

MovedArm::State RobotRunner::arm_state() {
  const std::lock_guard lock(mutex_);
  const simulation::ArmDrive& arm = world_.arm();
  return {arm.status(),   arm.at_rest(),       world_.stopped_by_contact(),
          arm.time(),     arm.largest_error(), arm.desired(),
          arm.position(), arm.reason()};
}

std::uint64_t RobotRunner::move_hand(const simulation::HandCommand& command, std::int64_t stamp) {
  const std::lock_guard lock(mutex_);
  world_.move_hand(command);
  hand_stamp_ = stamp;
  hand_commanded_ = false;
  hand_taker_ = "another command took the hand over";
  return ++hand_ticket_;
}

bool RobotRunner::command_hand(const simulation::JointsRequest& request, std::int64_t stamp) {
  const std::lock_guard lock(mutex_);
  if (stamp != 0 && stamp <= hand_stamp_) return false;
  world_.command_hand(check_joints_request(world_, request));
  hand_taker_ = request.mode == robot::JointMode::kStop ? "stopped by /hand/command"
                                                        : "another command took the hand over";
  ++hand_ticket_;
  hand_commanded_ = true;
  command_time_ = world_.time();
  return true;
}

void RobotRunner::stop_hand(const std::string& why) {
  const std::lock_guard lock(mutex_);
  world_.stop_hand();
  hand_commanded_ = false;
  hand_taker_ = why;
  ++hand_ticket_;
}

std::string RobotRunner::loss_of_hand(std::uint64_t ticket) {
  const std::lock_guard lock(mutex_);
  return ticket == hand_ticket_ ? std::string() : hand_taker_;
}

void RobotRunner::wait_for_slice() {
  std::unique_lock lock(mutex_);
  const std::uint64_t before = slices_;
  slice_done_.wait_for(lock, std::chrono::milliseconds(100), [&] { return slices_ != before; });
}

}  // namespace prehend::nodes
