#include "prehend/control/arm_in_world.h"

#include <stdexcept>

#include "prehend/simulation/hand_request.h"

namespace prehend::control {

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

ArmInWorld::ArmInWorld(simulation::RobotWorld& world) : world_(world), arm_(*this), hand_(world) {
  for (const robot::HandPad& pad : world.hand_model().pads) {
    felt_.emplace(pad.name, touch::felt_pad_of(pad));
  }
}

void ArmInWorld::follow(const simulation::TrajectoryRequest& request, double contact_force) {
  try {
    world_.follow(request);
    world_.stop_on_contact(contact_force);
  } catch (const std::invalid_argument&) {
    world_.arm().forget();
    throw;
  }
}

ArmPercepts ArmInWorld::percepts(int touch_counts) {
  ArmPercepts percepts;
  percepts.time = world_.time();
  for (const simulation::JointReading& joint : world_.joints()) {
    percepts.names.push_back(joint.name);
    percepts.positions.push_back(joint.position);
  }
  const auto wrench = world_.wrist_wrench();
  percepts.wrist_force = wrench.force;
  percepts.wrist_torque = wrench.torque;
  for (const simulation::HandPadReading& pad : world_.pads()) {
    const auto& felt = felt_.at(pad.name);
    percepts.pads.push_back(
        {pad.sum, robot::touched_area(pad.counts, touch_counts, felt->layout), 0, pad.name});
    percepts.frames.push_back({pad.name, felt, {pad.counts.begin(), pad.counts.end()}});
  }
  return percepts;
}

}  // namespace prehend::control
