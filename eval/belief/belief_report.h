#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/belief/touch_trial.h"

namespace prehend::eval {

/// How a way to take in touches did, over the views of a group that were touched by it.
struct BeliefTotals {
  std::string group;  // "all": of all groups
  std::string series;
  int views = 0;
  /// One for each number of touches. A view that could be touched no more keeps its last figures.
  struct Touched {
    double unseen = kUnknown;   // m
    double chamfer = kUnknown;  // m
    double jaccard = kUnknown;
    double worse = kUnknown;    // share of the touches that made the unseen surface 0.3 mm worse
    double seconds = kUnknown;  // of an update with its surface
    double change = kUnknown;   // of `unseen`, beside the prediction that nothing was told
  };
  std::vector<Touched> touched;
};
std::vector<BeliefTotals> belief_totals(const std::vector<BeliefCase>& cases);

/// For the terminal; as JSON; as a page in `folder`.
std::string belief_text(const std::vector<BeliefCase>& cases);
std::string belief_json(const std::vector<BeliefCase>& cases);
void write_belief_report(const std::filesystem::path& folder, const std::vector<BeliefCase>& cases);

}  // namespace prehend::eval
