#include "prehend/grasp/generators/generator.h"

#include "prehend/robot/gripper_model.h"
#include "prehend/text/require.h"

namespace prehend::grasp {

HandReach hand_reach(const robot::GripperModel& gripper) {
  return {gripper.tip_z(), gripper.pad.length(), gripper.max_opening};
}

void GeneratorOptions::validate() const {
  const text::Require require{"GeneratorOptions."};
  circles.validate();
  require(samples > 0, "samples must be positive");
  require(approaches > 0, "approaches must be positive");
  require(rolls > 0, "rolls must be positive");
  require(standoffs > 0, "standoffs must be positive");
  require(least_engagement > 0, "least_engagement must be positive");
  require(table_clearance >= 0, "table_clearance must not be negative");
  require(friction > 0, "friction must be positive");
}

}  // namespace prehend::grasp
