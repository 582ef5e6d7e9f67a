#pragma once

#include <string>
#include <vector>

#include "prehend/robot/pad_calibration.h"
#include "prehend/robot/pad_fit/foam_fit.h"

namespace prehend::robot {

struct PadFitOptions {
  int rows = 14, columns = 6;
  double texel_pitch = 0.0034;  // m, square
  int full_scale = 4095;        // counts
  FoamFitOptions foam;          // reference_texels is set from the pad's area
};

struct PadFit {
  PadCalibration calibration;
  std::vector<FittedValue> values;  // newton_per_count, noise, lag of the frames, then the foam's
  std::vector<double> gain_deviations;  // of calibration.gains
  FoamFit foam;
  std::vector<std::string> remarks;
};

/// Finds what a pad is like from a log of presses by a flat face that covers it all, one row for
/// each frame: the foam by fit_foam(), then each texel's counts as a line over its share of the
/// reference's force, with the frames' lag as slope over the force's rate. Rows near nothing and at
/// full scale are left out; the noise is what second differences show. A texel that does not answer
/// is dead: gain 0.
/// @throws geometry::InputError as fit_foam(), for a log of another number of texels, for texels at
/// full scale in nearly all presses, when none answers.
PadFit fit_pad(const PressingLog& log, const PadFitOptions& options);

/// As a file that read_pad_calibration() reads, with deviations as comments; `from` says of what.
std::string to_yaml(const PadFit& fit, const std::string& from);

}  // namespace prehend::robot
