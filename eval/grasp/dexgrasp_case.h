#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "eval/data_sets.h"
#include "eval/grasp/dexgrasp_trial.h"

namespace prehend::eval {

/// Which grasps count as one: roots nearer than `shift` whose turns differ by less than `turn`, all
/// motors by less than `joint` (`slide` of those that slide).
struct DexDistance {
  double shift = 0.005;           // m
  double turn = 10 * M_PI / 180;  // rad
  double joint = 0.1;             // rad
  double slide = 0.002;           // m
};

/// How many of `grasps`, in their order, are like none of those before that counted.
int distinct_grasps(const robot::HandModel& hand, const std::vector<grasp::Grasp>& grasps,
                    const DexDistance& distance = {});

/// What is done in a case.
struct DexChoice {
  DexProtocol protocol;
  std::uint64_t seed = 1;               // of the candidates and of the trials for robustness
  int grasps = 6;                       // >= 0, tried of each plan, best first
  int threads = 1;                      // > 0, of planning
  std::vector<std::string> generators;  // of candidates; empty: the hand's own
  int samples = 0;                      // of the surface, of generators; 0: as it ships
  /// Whether grasps are ranked by the planner's disturbed trials, too, as it ships.
  bool robust = true;
};

/// A hand, an object and a test.
struct DexCase {
  std::string hand, group, object;
  DexTest test = DexTest::kForceClosure;
  std::string problem;  // why nothing was planned
  // All that a plan without a limit to its length finds: how fast grasps are made.
  int candidates = 0;
  int valid = 0;       // by force closure, closed, reached without a collision, carrying the weight
  int distinct = 0;    // of these
  double seconds = 0;  // of wall clock
  double processor_seconds = 0;  // of all threads
  int listed = 0;                // by the plan as it ships, of which the best are tried
  std::vector<DexOutcome> tried;
};

/// Plans with the planner's defaults on the truth, its weight and friction being the benchmark's,
/// and tries the best grasps. What cannot be planned is the case's problem. Repeatable but for the
/// seconds.
/// @throws as run_dex_trial(), geometry::InputError for a mesh that encloses no volume.
DexCase run_dex_case(const DexHand& hand, const DataSet& object, DexTest test,
                     const DexChoice& choice);

/// As YAML, and back. @throws geometry::InputError for a text that is no result.
std::string to_text(const DexCase& result);
DexCase read_dex_case(const std::string& text);

}  // namespace prehend::eval
