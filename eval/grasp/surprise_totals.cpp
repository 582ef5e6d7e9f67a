#include "eval/grasp/surprise_totals.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include <fmt/format.h>

namespace prehend::eval {
namespace {

using control::Surprise;
using control::SurpriseKind;

/// Of one platform and setting.
struct FeltByKind {
  std::string platform, setting;
  int attempts = 0;
  std::map<SurpriseKind, std::vector<Surprise>> kinds;
};

// Of those that are known; kUnknown of none.
double middle_of(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty()) return kUnknown;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::vector<SurpriseTotals> surprise_totals(const std::vector<GraspCase>& cases) {
  std::vector<FeltByKind> all;
  for (const GraspCase& one : cases) {
    if (!one.fits()) continue;
    for (const GraspTrial& trial : one.executed()) {
      auto found = std::find_if(all.begin(), all.end(), [&](const FeltByKind& felt) {
        return felt.platform == one.platform && felt.setting == trial.setting;
      });
      if (found == all.end()) found = all.insert(all.end(), {one.platform, trial.setting, 0, {}});
      found->attempts += trial.attempts;
      for (const Surprise& surprise : trial.surprises) {
        found->kinds[surprise.kind].push_back(surprise);
      }
    }
  }
  std::vector<SurpriseTotals> totals;
  for (const FeltByKind& felt : all) {
    for (const auto& [kind, surprises] : felt.kinds) {
      std::vector<double> differences;
      for (const Surprise& s : surprises) differences.push_back(s.felt - s.predicted);
      const auto surprising = std::count_if(surprises.begin(), surprises.end(),
                                            [](const Surprise& s) { return s.surprising; });
      totals.push_back({felt.platform, felt.setting, kind, felt.attempts,
                        static_cast<int>(surprises.size()), static_cast<int>(surprising),
                        middle_of(std::move(differences))});
    }
  }
  return totals;
}

const std::vector<std::string>& surprises_header() {
  static const std::vector<std::string> header{
      "platform", "planned on", "attempts", "what", "compared", "surprises", "felt less predicted"};
  return header;
}

std::vector<std::vector<std::string>> surprises_rows(const std::vector<GraspCase>& cases) {
  std::vector<std::vector<std::string>> rows;
  for (const SurpriseTotals& t : surprise_totals(cases)) {
    const std::string share =
        t.attempts > 0 ? fmt::format(" ({:.0f} % of attempts)", 100.0 * t.surprising / t.attempts)
                       : "";
    rows.push_back({t.platform, t.setting, fmt::format("{}", t.attempts), to_string(t.kind),
                    fmt::format("{}", t.compared), fmt::format("{}{}", t.surprising, share),
                    fmt::format("{:.3g} {}", t.difference, unit_of(t.kind))});
  }
  return rows;
}

}  // namespace prehend::eval
