#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "prehend/contact/texel_law.h"

namespace prehend::robot {

struct TactilePadModel;

/// What was measured of one pad, e.g. by `prehend calibrate tactile`. Drivers make counts of one
/// unit with it, simulated pads have these errors and this foam:
///   count of texel i = gains[i] * force / newton_per_count + zeros[i]
struct PadCalibration {
  int rows = 14, columns = 6;   // row 0 at the fingertip
  double newton_per_count = 0;  // N
  std::vector<double> gains;    // rows * columns, relative, mean 1; 0: a dead texel; empty: all 1
  std::vector<double> zeros;    // counts without load; empty: all 0
  double noise = 0;             // counts, standard deviation
  std::optional<double> stiffness;  // N/m, of a texel of reference area
  std::optional<double> damping;    // N s/m
  contact::FoamMemory memory;

  /// The law with what was measured of it in its place.
  contact::TexelLaw law_over(const contact::TexelLaw& law) const;
};

/// Reads a map rows, columns, newton_per_count, gains, zeros, noise and law (stiffness, damping,
/// creep, hysteresis). Without `newton_per_count` it is no calibration.
/// @throws geometry::InputError "file:line: ...": unknown key, wrong type, a value out of range, a
/// list that has not one value for each texel.
PadCalibration read_pad_calibration(const std::filesystem::path& path);
PadCalibration parse_pad_calibration(const std::string& yaml, const std::filesystem::path& path);

/// @throws std::invalid_argument naming the field.
void validate(const PadCalibration& calibration);
/// @throws std::invalid_argument when it is of a pad of other texels, or its law is not linear.
void require_of(const PadCalibration& calibration, const TactilePadModel& pad);

}  // namespace prehend::robot
