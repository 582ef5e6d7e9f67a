#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/dsa/codec/frame.h"
#include "drivers/dsa/codec/structures.h"
#include "msgs/sensors.pb.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/robot/pad_calibration.h"

namespace prehend::drivers::dsa {

/// A pad of the gripper that a matrix of the controller is.
struct Pad {
  std::string name;        // topic /tactile/NAME, frame NAME_pad
  std::size_t matrix = 0;  // index in the controller
  bool flip_rows = false;  // the controller's row 0 is at the palm
  bool flip_columns = false;
  double newton_per_count = robot::kDsaNewtonPerCount;
  /// Of the pad as published: then counts are corrected by its zeros and gains, and its
  /// newton_per_count counts.
  std::optional<robot::PadCalibration> calibration = {};
};

/// The part of a frame that is this pad's, row 0 nearest the fingertip. `stamp` [ns]. The texel
/// pitch is the controller's. @throws std::invalid_argument when the controller has no such matrix,
/// or one of another size than the calibration.
msgs::TactileFrame pad_message(const Pad& pad, const Frame& frame,
                               const std::vector<MatrixInfo>& matrices, std::int64_t stamp);

}  // namespace prehend::drivers::dsa
