#pragma once

#include <string>
#include <vector>

#include "eval/grasp/grasp_case.h"

namespace prehend::eval {

/// What one platform's executions of one setting felt, of one kind of comparison.
struct SurpriseTotals {
  std::string platform;
  std::string setting;
  control::SurpriseKind kind = control::SurpriseKind::kMotion;
  int attempts = 0;  // of the platform on the setting, of which this is told
  int compared = 0;  // times, > 0; of what is only told when it surprises, as often
  int surprising = 0;
  double difference = kUnknown;  // median of felt less predicted, in the kind's unit
};

/// Over cases whose object fits the hand: by platform and setting as they first come, then by kind.
std::vector<SurpriseTotals> surprise_totals(const std::vector<GraspCase>& cases);

/// The same as a table for people.
const std::vector<std::string>& surprises_header();
std::vector<std::vector<std::string>> surprises_rows(const std::vector<GraspCase>& cases);

}  // namespace prehend::eval
