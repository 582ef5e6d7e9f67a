#pragma once

#include <functional>
#include <string>
#include <vector>

#include "prehend/contact/grasp_stepper.h"

namespace prehend::eval::touch {

/// A grasp with one value far from the usual: a box between two pads, jaws pressed from t = 0.
struct Extreme {
  std::string subject;  // e.g. "mass ratio"
  std::string value;    // e.g. "1:10000"
  contact::GraspModel model;
  double force = 5;                                          // N of each jaw
  double step = 1e-3;                                        // s, first order
  double duration = 0.5;                                     // s
  Eigen::Vector3d start_velocity = Eigen::Vector3d::Zero();  // m/s, of the box
  std::string refused;  // what the message of the refusal names; empty: it is to run
  bool is_held = true;  // at the end; false: it flies through
  std::string limit;    // why it cannot be held; empty: it is
};

struct ExtremeResult {
  bool refused = false;
  std::string message;       // of the refusal
  bool stable = false;       // finite, bounded energy, no faster than it was thrown or fell
  double sliding = 0;        // m/s of the box along the pads at the end, swings left out
  bool held = false;         // it does not slide by more than kStill
  double energy_growth = 0;  // most energy seen over what was there and put in by jaws, relative
  double final_speed = 0;    // m/s of the box
  double error = 0;          // m, of the box's centre at the end, to the reference
};

/// m/s: less than 5 mm in 50 s.
inline constexpr double kStill = 1e-4;

/// All rows of docs/touch_extremes.md, in its order.
std::vector<Extreme> extremes();

/// Runs one, and beside it, if asked for, a second-order reference of 20 times finer steps (within
/// 1 to 20 us).
ExtremeResult run_extreme(const Extreme& extreme, bool with_reference = true);

/// Whether it ended as `extreme` says: held, not held where that is a limit, or refused by the
/// name.
bool is_as_expected(const Extreme& extreme, const ExtremeResult& result);

/// "held", "stable" (of what flies through), "limit: why", "slides", "UNSTABLE" or "refused: why".
std::string outcome(const Extreme& extreme, const ExtremeResult& result);

/// The table in Markdown.
std::string extremes_markdown(const std::vector<Extreme>& cases,
                              const std::vector<ExtremeResult>& results);

}  // namespace prehend::eval::touch
