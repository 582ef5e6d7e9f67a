#pragma once

#include <string>
#include <vector>

#include "msgs/sensors.pb.h"
#include "msgs/touch.pb.h"
#include "prehend/robot/hand_model.h"
#include "prehend/touch/pad_touch.h"
#include "prehend/touch/slip_watch.h"

namespace prehend::convert {

/// The pad that sent `frame`: counts and calibration are the frame's, foam the pad's; texels the
/// frame's on a flat grid, on any other surface the pad's cells, of which the frame has one count
/// each. `mirrored`: see touch::felt_pad, of a flat grid. @throws std::invalid_argument for a frame
/// without texels, with another number of counts, or without sizes of its texels, counts or
/// calibration.
touch::FeltPad felt_pad(const msgs::TactileFrame& frame, const robot::HandPad& pad, bool mirrored);

std::vector<double> counts_of(const msgs::TactileFrame& frame);

msgs::PadTouch to_message(const std::string& pad, const touch::PadTouch& touch);

/// Adds what frames tell of slip, or to not_determined why they do not. `columns`: texels a row.
void add_slip(const touch::SlipReading& slip, int columns, msgs::PadTouch* message);

}  // namespace prehend::convert
