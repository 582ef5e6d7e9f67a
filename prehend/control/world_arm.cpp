#include "prehend/control/world_arm.h"

#include <stdexcept>
#include <utility>

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
  arm_.stop();
  waiting_.reset();
  if (arm_.at_rest()) return begin(way);
  waiting_ = std::move(way);
}

void WorldArm::begin(const Way& way) {
  try {
    arm_.follow(way.request, way.contact_force);
  } catch (const std::invalid_argument& error) {
    problem_ = error.what();
  }
}

MotionStatus WorldArm::motion() {
  if (waiting_) {
    if (!arm_.at_rest()) return MotionStatus::kMoving;
    begin(*std::exchange(waiting_, std::nullopt));
  }
  if (!problem_.empty()) return MotionStatus::kFailed;
  const ArmDrive::Status status = arm_.drive().status();
  if (status == ArmDrive::Status::kReached) return MotionStatus::kReached;
  if (status == ArmDrive::Status::kMoving || !arm_.at_rest()) return MotionStatus::kMoving;
  if (status != ArmDrive::Status::kOffPath && arm_.stopped_by_contact()) {
    return MotionStatus::kContact;
  }
  problem_ = status == ArmDrive::Status::kOffPath ? arm_.drive().reason()
                                                  : std::string("stopped before the goal");
  return MotionStatus::kFailed;
}

void WorldArm::stop() {
  waiting_.reset();
  arm_.stop();
}

}  // namespace prehend::control
