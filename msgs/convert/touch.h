#pragma once

#include "msgs/grasp.pb.h"
#include "prehend/planning/touch_prediction.h"

namespace prehend::convert {

/// Adds what the pads of `hand` are predicted to feel, or why it is not known. Pads that feel
/// nothing are left out. Sums and areas of `percepts` stay as they are.
void add_touch(const planning::PredictedTouch& touch, const robot::HandModel& hand,
               msgs::PredictedPercepts* percepts);

}  // namespace prehend::convert
