#include "prehend/robot/learning/joint_offsets.h"

namespace prehend::robot::learning {
namespace {

using formats::JointDescription;

// The joint's zero is where it stood at `offset`.
void shift(JointDescription& joint, double offset) {
  if (joint.kind == JointDescription::Kind::kPrismatic) {
    joint.X_PJ.translate(offset * joint.axis_J);
  } else {
    joint.X_PJ.rotate(Eigen::AngleAxisd(offset, joint.axis_J));
  }
  if (joint.lower) *joint.lower -= offset;
  if (joint.upper) *joint.upper -= offset;
  joint.rest -= offset;
}

}  // namespace

void fold_offsets(formats::RobotDescription& robot) {
  for (bool found = true; found;) {
    found = false;
    for (JointDescription& joint : robot.joints) {
      if (!joint.follows || joint.follows->offset() == 0) continue;
      const double offset = joint.follows->offset();
      shift(joint, offset);
      joint.follows->coefficients[0] = 0;
      for (JointDescription& other : robot.joints) {
        if (other.follows && other.follows->joint == joint.name) {
          other.follows->coefficients[0] += other.follows->multiplier() * offset;
          found = true;
        }
      }
      for (formats::Posture& posture : robot.postures) {
        const auto position = posture.positions.find(joint.name);
        if (position != posture.positions.end()) position->second -= offset;
      }
    }
  }
}

}  // namespace prehend::robot::learning
