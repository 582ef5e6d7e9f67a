#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/grasp/grasp_case.h"

namespace prehend::eval {

/// One setting's figures over those cases of one platform and group whose object fits it.
struct GraspTotals {
  std::string group;  // or "all"
  std::string platform;
  std::string setting;
  int cases = 0;      // whose object fits
  int unplanned = 0;  // of them: no grasp was found
  int first = 0;      // lifted, carried and put down at the first attempt
  int within_three = 0;
  double slip = kUnknown;           // m, median of those lifted
  double contact_error = kUnknown;  // m, median of those tried
  double area_error = kUnknown;     // median of the absolute values
  double opening_error = kUnknown;  // m, median of the absolute values
  double plan_seconds = kUnknown;   // median

  double first_share() const { return cases > 0 ? static_cast<double>(first) / cases : kUnknown; }
  double within_three_share() const {
    return cases > 0 ? static_cast<double>(within_three) / cases : kUnknown;
  }
};

/// Of each platform, group and setting, in the order of their first case; of all groups where there
/// are several.
std::vector<GraspTotals> grasp_totals(const std::vector<GraspCase>& cases);

/// Tables for people, to be printed: totals, each object, the reasons of failures.
std::string grasp_text(const std::vector<GraspCase>& cases);

/// Totals, goals and each case as one JSON object.
std::string grasp_json(const std::vector<GraspCase>& cases);

/// Writes index.html (goals, charts, tables) and cases.csv into `folder`.
/// @throws std::runtime_error naming a file that cannot be written.
void write_grasp_report(const std::filesystem::path& folder, const std::vector<GraspCase>& cases);

}  // namespace prehend::eval
