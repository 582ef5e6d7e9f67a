#pragma once

#include "msgs/sensors.pb.h"
#include "prehend/robot/hand_model.h"

namespace prehend::convert {

/// Where the cells of the pads of `hand` are.
msgs::TactileCells cells_message(const robot::HandModel& hand);

}  // namespace prehend::convert
