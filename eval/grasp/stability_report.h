#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/grasp/stability_fit.h"
#include "eval/grasp/stability_trials.h"

namespace prehend::eval {

/// How well some trials were told apart.
struct StabilityScore {
  std::string moment;  // "closed", "lifting"
  std::string hand;    // a platform, or "all"
  std::string pads;    // "ideal", "realistic", "all"
  std::string model;   // "one" of all hands, or of "each" hand
  int grasps = 0, held = 0;
  double area = 0;  // under the ROC curve
  AreaBounds bounds;
  std::vector<std::pair<double, double>> curve;
};

struct StabilityFindings {
  int trials = 0, counted = 0;  // counted: closed and felt something
  int lost_before = 0;          // of them: the cycle ended before the hand had risen by kAsked
  std::vector<StabilityScore> scores;
  std::vector<double> closed, lifting;  // of each trial, the one model's; NaN: not asked
};

/// What each trial is asked at a moment, in the order of the trials that can be asked then.
/// @return index of the trial and what is known.
std::vector<std::pair<std::size_t, KnownHold>> known_holds(
    const std::vector<StabilityTrial>& trials, touch::GripMoment moment);

/// Each object answered by a model of the others (crossed_probabilities(), ten folds). A grasp that
/// had gone before the hand rose is asked about when closed, not when lifting.
StabilityFindings stability_findings(const std::vector<StabilityTrial>& trials);

/// A table for people.
std::string stability_text(const StabilityFindings& findings);
std::string stability_json(const StabilityFindings& findings);
/// Writes index.html (curves, table) and trials.csv into `folder`.
/// @throws std::runtime_error naming a file that cannot be written.
void write_stability_report(const std::filesystem::path& folder, const StabilityFindings& findings,
                            const std::vector<StabilityTrial>& trials);

/// The model of all trials.
touch::GraspStability fitted_stability(const std::vector<StabilityTrial>& trials);

}  // namespace prehend::eval
