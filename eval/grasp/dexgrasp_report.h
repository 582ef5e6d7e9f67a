#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/grasp/dexgrasp_case.h"

namespace prehend::eval {

/// Several cases' figures.
struct DexTotals {
  std::string name;  // of the hand or of the object
  std::string test;
  int cases = 0, unplanned = 0;  // unplanned: the plan has no grasp
  int tried = 0, held = 0;
  int held_first = 0;  // cases whose best grasp held
  // m, means and the largest of what was tried and did not fail at its start
  double depth = 0, largest_depth = 0, self_depth = 0, largest_self_depth = 0;
  int candidates = 0, valid = 0, distinct = 0;
  double seconds = 0, processor_seconds = 0;

  double share() const { return tried > 0 ? static_cast<double>(held) / tried : 0; }
};

/// Of each hand and test, in the order of their first case.
std::vector<DexTotals> totals_by_hand(const std::vector<DexCase>& cases);
/// Of each object and test, over all hands.
std::vector<DexTotals> totals_by_object(const std::vector<DexCase>& cases);

/// Tables for people: totals, how fast, how grasps were lost.
std::string dex_text(const std::vector<DexCase>& cases);
/// Totals as JSON, without seconds: the same for the same choice on every machine's run.
std::string dex_json(const std::vector<DexCase>& cases);
/// Writes index.html, trials.csv and cases.csv (each without seconds) and rates.csv (with them).
/// @throws std::runtime_error naming a file that cannot be written.
void write_dex_report(const std::filesystem::path& folder, const std::vector<DexCase>& cases);

}  // namespace prehend::eval
