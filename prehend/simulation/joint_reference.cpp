#include "prehend/simulation/joint_reference.h"

#include <algorithm>
#include <cmath>

#include "prehend/simulation/trapezoid.h"

namespace prehend::simulation {

using robot::JointMode;

void JointReference::advance(const ActuatedJoint& joint, double acceleration, double h,
                             const JointMotion& start, double effort) {
  // A joint that lags by more than what its greatest effort needs is blocked (SpindleDrive::lead).
  const double most_lead = 1.2 * joint.max_effort / joint.stiffness;
  if (moves_by_itself()) {
    // Bumpless: where the loop would ask for the effort that is there.
    position = start.position + std::clamp(effort / joint.stiffness, -most_lead, most_lead);
    velocity = start.velocity;
    return;
  }
  const double cut = std::clamp(position, start.position - most_lead, start.position + most_lead);
  if (cut != position) {
    position = cut;
    velocity =
        std::clamp(velocity, start.velocity - acceleration * h, start.velocity + acceleration * h);
  }
  if (mode == JointMode::kPosition) {
    velocity =
        next_trapezoid_speed(value - position, velocity, joint.max_velocity, acceleration, h);
  } else if (value != 0) {
    const double end = value > 0 ? joint.upper : joint.lower;
    velocity = next_trapezoid_speed(end - position, velocity,
                                    std::min(std::abs(value), joint.max_velocity), acceleration, h);
  } else {
    velocity -= std::clamp(velocity, -acceleration * h, acceleration * h);
  }
  position += h * velocity;
}

ActuatorRequest JointReference::request(const ActuatedJoint& joint) const {
  if (mode == JointMode::kVoltage) return {mode, value, 0, joint.max_effort};
  if (mode == JointMode::kEffort) {
    return {mode, std::clamp(value, -joint.max_effort, joint.max_effort), 0, joint.max_effort};
  }
  return {JointMode::kPosition, position, velocity, joint.max_effort};
}

double JointReference::most_speed(const ActuatedJoint& joint, double acceleration, double h,
                                  double position_now) const {
  const double left = value > 0 ? joint.upper - position_now : position_now - joint.lower;
  return std::min(joint.max_velocity, stopping_speed(std::max(0.0, left), acceleration, h));
}

}  // namespace prehend::simulation
