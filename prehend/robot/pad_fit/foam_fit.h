#pragma once

#include <functional>
#include <string>
#include <vector>

#include "prehend/contact/texel_law.h"
#include "prehend/robot/pad_fit/pressing_log.h"

namespace prehend::robot {

/// A number that was found, with its standard deviation.
struct FittedValue {
  std::string name, unit;
  double value = 0, deviation = 0;
};

/// How many terms of each kind, and what is not fitted.
struct FoamFitOptions {
  double reference_texels = 84;  // the pad's area in texels of contact::kReferenceTexelArea
  int creep_terms = 1;           // 0 to 3
  int hysteresis_terms = 1;      // 0 to 3
  contact::TexelLaw law;         // what is not fitted, damping where the log does not show it
  /// Standard deviation over value above which the log does not determine a value.
  double most_deviation = 0.25;
  /// After each round: its number, and what forces are off by over the largest (root of the mean
  /// square). May be empty.
  std::function<void(int round, double off)> progress;
};

struct FoamFit {
  contact::TexelLaw law;
  double face = 0, face_deviation = 0;  // m, depth of the log at which the face meets the pad
  std::vector<FittedValue> values;  // stiffness, damping, then of each term share, time or depth
  double off = 0;                   // N, root of the mean square
  double most_force = 0;            // N, of the log
  int presses = 0;
  std::vector<std::string> remarks;
};

/// Finds the foam's law from depths and forces: least squares over the steps of
/// contact::FoamTexel (Ceres, Levenberg and Marquardt), begun from the best of a grid of times and
/// depths, for which the rest is linear. Standard deviations are those of the linearised problem,
/// widened by the residuals' correlation from row to row.
/// @throws geometry::InputError naming what the log does not determine, and what to press for it.
FoamFit fit_foam(const PressingLog& log, const FoamFitOptions& options);

/// Forces of the whole pad [N] at the log's times, the face being met at `face` [m].
std::vector<double> predicted_forces(const PressingLog& log, const contact::TexelLaw& law,
                                     double reference_texels, double face);

/// What a law predicts of another log, where only the face is found anew.
struct FoamCheck {
  double face = 0;        // m
  double off = 0;         // N, root of the mean square
  double most_off = 0;    // N
  double most_force = 0;  // N, of the log
};
FoamCheck check_foam(const PressingLog& log, const contact::TexelLaw& law, double reference_texels);

}  // namespace prehend::robot
