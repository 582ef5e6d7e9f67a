#pragma once

#include "prehend/robot/formats/loss_report.h"
#include "prehend/robot/formats/robot_description.h"

namespace prehend::robot::formats {

/// Whether a joint turns about, or slides along, one axis.
bool has_axis(const JointDescription& joint);
/// Whether such a joint's limits leave it no way from 0: readers of COLLADA take it for fixed.
bool is_held(const JointDescription& joint);

/// All that a COLLADA document with OpenRAVE's extras cannot say of a robot, and what it says.
void tell_collada_losses(const RobotDescription& robot, LossReport& loss);

}  // namespace prehend::robot::formats
