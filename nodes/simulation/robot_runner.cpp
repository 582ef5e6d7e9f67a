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
    : world_(std::move(world)),
      steps_(std::max(1, static_cast<int>(std::lround(static_cast<double>(slice) * 1e-9 /
                                                      world_.options().step)))),
      on_readings_(std::move(on_readings)),
      loop_(
          node, pacer, slice, [this] { this->slice(); }, std::move(on_pace)) {}

void RobotRunner::slice() {
  RobotReadings readings;
  {
    const std::lock_guard lock(mutex_);
    for (int i = 0; i < steps_; ++i) world_.step();
    readings = read();
    ++slices_;
  }
  slice_done_.notify_all();
  on_readings_(readings);
}

RobotReadings RobotRunner::read() const {
  RobotReadings readings;
  readings.stamp = std::llround(world_.time() * 1e9);
  readings.joints = world_.joints();
  readings.pads = world_.pads();
  readings.wrench = world_.wrist_wrench();
  for (std::size_t i = 0; i < world_.body_count(); ++i) readings.bodies.push_back(world_.body(i));
  return readings;
}

std::uint64_t RobotRunner::take_arm() {
  const std::lock_guard lock(mutex_);
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
  try {
    world_.follow(request, tolerance);
  } catch (const std::invalid_argument&) {
    world_.arm().forget();
    throw;
  }
  if (contact_force > 0) world_.stop_on_contact(contact_force);
}

MovedArm::State RobotRunner::arm_state() {
  const std::lock_guard lock(mutex_);
  const simulation::ArmDrive& arm = world_.arm();
  return {arm.status(),   arm.at_rest(),       world_.stopped_by_contact(),
          arm.time(),     arm.largest_error(), arm.desired(),
          arm.position(), arm.reason()};
}

std::uint64_t RobotRunner::take_hand() {
  const std::lock_guard lock(mutex_);
  return ++hand_ticket_;
}

bool RobotRunner::holds_hand(std::uint64_t ticket) {
  const std::lock_guard lock(mutex_);
  return ticket == hand_ticket_;
}

void RobotRunner::wait_for_slice() {
  std::unique_lock lock(mutex_);
  const std::uint64_t before = slices_;
  slice_done_.wait_for(lock, std::chrono::milliseconds(100), [&] { return slices_ != before; });
}

}  // namespace prehend::nodes
