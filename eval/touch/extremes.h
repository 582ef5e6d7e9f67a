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
};

struct ExtremeResult {
  bool refused = false;
  std::string message;       // of the refusal
  bool stable = false;       // finite, bounded energy, at rest or held at the end
  double energy_growth = 0;  // most energy seen over what was there and put in by jaws, relative
  double final_speed = 0;    // m/s of the box
  double error = 0;          // m, of the box's centre at the end, to the reference
};

/// All rows of docs/touch_extremes.md, in its order.
std::vector<Extreme> extremes();

/// Runs one, and beside it, if asked for, a second-order reference of 20 times finer steps (within
/// 1 to 20 us).
ExtremeResult run_extreme(const Extreme& extreme, bool with_reference = true);

/// "stable", "UNSTABLE" or "refused: why".
std::string outcome(const ExtremeResult& result);

/// The table in Markdown.
std::string extremes_markdown(const std::vector<Extreme>& cases,
                              const std::vector<ExtremeResult>& results);

}  // namespace prehend::eval::touch
