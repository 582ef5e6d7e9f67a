#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/belief/toucher.h"
#include "eval/case_result.h"
#include "eval/data_sets.h"
#include "prehend/belief/shape_hypothesis.h"

namespace prehend::eval {

/// The series of one step that is the prediction as nodes make it.
inline const std::string kPredictionSeries = "prediction";

/// How far the believed surface is from the truth.
struct BeliefStep {
  int touches = 0;            // that were made
  double unseen = kUnknown;   // m, mean distance of the true surface that was not seen, to it
  double chamfer = kUnknown;  // m, mean of both directions' mean distances
  double jaccard = kUnknown;  // volume of both over that of either
  double weight = kUnknown;   // of the likeliest shape
  double misfit = kUnknown;   // of the likeliest shape
  double seconds = kUnknown;  // processor time of the update and its surface
};

/// One of the shapes that the object may have, before anything was felt.
struct TriedShape {
  belief::PriorTerms terms;
  double unseen = kUnknown;  // m, as BeliefStep
};

/// One way to take in touches.
struct BeliefSeries {
  std::string name;
  std::string problem;  // why it ended
  std::vector<BeliefStep> steps;
};

/// One view of an object, and what touches made of it.
struct BeliefCase {
  std::string case_name, group, data_set;
  int orientation = 0;  // degrees
  std::string problem;  // why there is nothing
  std::vector<BeliefSeries> series;
  std::vector<TriedShape> shapes;
};

/// Of this view, nothing in it yet.
BeliefCase belief_case_of(const Case& one);

struct TouchTrialOptions {
  int touches = 5;
  const TouchingHand* hand = nullptr;  // null: a fingertip
  TouchNoise noise;
};

/// Renders the case's view, predicts the object, and touches it where the belief wants it: each
/// series its own touches. Of a fingertip that tells all there is a second series: what the
/// classical baseline (gaussian_surface.h) makes of the same evidence.
BeliefCase run_touch_trial(const Case& one, const TouchTrialOptions& options = {});

/// As YAML, and back. @throws geometry::InputError for a text that is no result.
std::string to_text(const BeliefCase& result);
BeliefCase read_belief_case(const std::string& text);

}  // namespace prehend::eval
