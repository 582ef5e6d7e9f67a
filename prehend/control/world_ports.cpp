#include "prehend/control/world_ports.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "prehend/simulation/hand_request.h"

namespace prehend::control {

using simulation::ArmDrive;

void WorldArm::follow(const JointTrajectory& path, double contact_force) {
  problem_.clear();
  Way way;
  way.contact_force = contact_force;
  way.request.joints = path.joints;
  for (const JointTrajectory::Point& point : path.points) {
    way.request.points.push_back({point.time, point.position, point.velocity, point.acceleration});
  }
  world_.arm().stop();
  waiting_.reset();
  if (world_.arm().at_rest()) return begin(way);
  waiting_ = std::move(way);
}

void WorldArm::begin(const Way& way) {
  try {
    world_.follow(way.request);
    world_.stop_on_contact(way.contact_force);
  } catch (const std::invalid_argument& error) {
    world_.arm().forget();
    problem_ = error.what();
  }
}

MotionStatus WorldArm::motion() {
  if (waiting_) {
    if (!world_.arm().at_rest()) return MotionStatus::kMoving;
    begin(*std::exchange(waiting_, std::nullopt));
  }
  if (!problem_.empty()) return MotionStatus::kFailed;
  const ArmDrive::Status status = world_.arm().status();
  if (status == ArmDrive::Status::kReached) return MotionStatus::kReached;
  if (status == ArmDrive::Status::kMoving || !world_.arm().at_rest()) return MotionStatus::kMoving;
  if (status != ArmDrive::Status::kOffPath && world_.stopped_by_contact()) {
    return MotionStatus::kContact;
  }
  problem_ = status == ArmDrive::Status::kOffPath ? world_.arm().reason()
                                                  : std::string("stopped before the goal");
  return MotionStatus::kFailed;
}

void WorldArm::stop() {
  waiting_.reset();
  world_.arm().stop();
}

void WorldHand::move(const std::vector<std::string>& joints, const std::vector<double>& positions,
                     double speed, bool until_contact, const std::vector<double>& effort) {
  problem_.clear();
  refused_ = false;
  motors_.clear();
  try {
    const simulation::NamedHandCommand named =
        check_hand_request(world_, {joints, positions, speed, until_contact, effort});
    world_.move_hand(named.command);
    motors_ = named.motors;
  } catch (const std::invalid_argument& error) {
    refused_ = true;
    problem_ = error.what();
  }
}

MotionStatus WorldHand::motion() {
  if (refused_) return MotionStatus::kFailed;
  const simulation::HandDrive& hand = world_.hand();
  if (hand.moving()) return MotionStatus::kMoving;
  if (hand.reached()) return MotionStatus::kReached;
  problem_ = hand.blocked() ? "blocked" : "stopped before the goal";
  return hand.blocked() ? MotionStatus::kContact : MotionStatus::kFailed;
}

std::vector<double> WorldHand::positions() {
  const Eigen::VectorXd all = world_.hand_positions();
  std::vector<double> named;
  for (const int motor : motors_) named.push_back(all[motor]);
  return named;
}

void WorldHand::stop() { world_.stop_hand(); }

ArmPercepts percepts_of(const simulation::RobotWorld& world, int touch_counts) {
  ArmPercepts percepts;
  percepts.time = world.time();
  for (const simulation::JointReading& joint : world.joints()) {
    percepts.names.push_back(joint.name);
    percepts.positions.push_back(joint.position);
  }
  percepts.wrist_force = world.wrist_wrench().force;
  for (const simulation::HandPadReading& pad : world.pads()) {
    const auto& pads = world.hand_model().pads;
    const auto model = std::find_if(pads.begin(), pads.end(),
                                    [&](const auto& one) { return one.name == pad.name; });
    const double pitch = model->model.texel_pitch;
    percepts.pads.push_back(
        {pad.sum, robot::touched_area(pad.counts, touch_counts, pitch * pitch), 0, pad.name});
  }
  return percepts;
}

}  // namespace prehend::control
