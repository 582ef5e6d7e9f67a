#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "eval/belief/surprise_trial.h"

namespace prehend::eval {

/// How a sense, or all of them, tells right predictions from others.
struct SenseScore {
  std::string objects;  // the group, "all"
  std::string sense;    // belief::percept_senses() or "total"
  int right = 0, others = 0;
  double false_alarms = 0;  // share of the right ones, at the model's thresholds
  double detected = 0;      // share of the others
  double area = 0;          // of the ROC curve; NaN without right ones or others
  std::vector<std::pair<double, double>> curve;
  /// Share that raises an alarm, for each of act_truths() but kRight; NaN: there is none.
  std::vector<double> by_truth;
};

struct SurpriseFindings {
  int cases = 0, without = 0;                  // cases; those with a problem
  int left_out = 0;                            // acts that were nothing that is asked for
  double prediction_seconds = 0;               // of processor, for a shape: median
  double bits_right = 0, deviation_right = 0;  // of the total: mean, standard deviation
  std::vector<SenseScore> scores;
};

/// @throws std::invalid_argument as belief::percept_surprise().
SurpriseFindings surprise_findings(const std::vector<SurpriseCase>& cases,
                                   const belief::SurpriseModel& model);
std::string surprise_text(const SurpriseFindings& findings);
std::string surprise_json(const SurpriseFindings& findings);
/// index.html with ROC curves, acts.csv with the bits of each act.
void write_surprise_report(const std::filesystem::path& folder, const SurpriseFindings& findings,
                           const std::vector<SurpriseCase>& cases,
                           const belief::SurpriseModel& model);

/// Fitted on the right predictions of `group` of a hand. @throws as belief::fit_surprise().
belief::SurpriseModel fitted_surprise(const std::vector<SurpriseCase>& cases,
                                      const std::string& group, double false_alarms,
                                      const robot::HandModel& hand);

}  // namespace prehend::eval
