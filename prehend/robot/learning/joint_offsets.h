#pragma once

#include "prehend/robot/formats/robot_description.h"

namespace prehend::robot::learning {

/// Puts offsets of joints that follow another into where they stand at 0, as engines couple joints
/// by a ratio alone: links stand where they stood, limits and postures count from there on.
/// @pre no joint follows itself by any way, and couplings are linear
void fold_offsets(formats::RobotDescription& robot);

}  // namespace prehend::robot::learning
