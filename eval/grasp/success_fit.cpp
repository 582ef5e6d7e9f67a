#include "eval/grasp/success_fit.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

namespace prehend::eval {
namespace {

double log_likelihood(const std::vector<KnownSuccess>& known, const SuccessLine& line) {
  double sum = 0;
  for (const double end : {line.of_none, line.of_all}) sum += std::log(end) + std::log(1 - end);
  for (const KnownSuccess& one : known) {
    const double p = line.at(one.held);
    sum += std::log(one.lifted ? p : 1 - p);
  }
  return sum;
}

SuccessCalibration calibration(const std::vector<KnownSuccess>& known,
                               const std::vector<double>& probabilities) {
  SuccessCalibration result;
  std::vector<std::pair<double, bool>> answers;
  for (std::size_t i = 0; i < known.size(); ++i) {
    answers.emplace_back(probabilities[i], known[i].lifted);
    result.lifted += known[i].lifted ? 1 : 0;
  }
  result.attempts = static_cast<int>(known.size());
  if (answers.empty()) return result;
  const auto all = static_cast<double>(answers.size());
  const double share = result.lifted / all;
  for (const auto& [p, lifted] : answers) {
    const double came = lifted ? 1 : 0;
    result.brier += (p - came) * (p - came) / all;
    result.brier_of_constant += (share - came) * (share - came) / all;
  }
  std::stable_sort(answers.begin(), answers.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  constexpr std::size_t kBins = 5;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    double foretold = 0, came = 0;
    for (std::size_t i = bin * answers.size() / kBins; i < (bin + 1) * answers.size() / kBins;
         ++i) {
      foretold += answers[i].first;
      came += answers[i].second ? 1 : 0;
    }
    result.calibration_error += std::abs(foretold - came) / all;
  }
  return result;
}

}  // namespace

std::vector<KnownSuccess> first_attempts(const std::vector<GraspCase>& cases) {
  std::vector<KnownSuccess> known;
  for (const GraspCase& one : cases) {
    const GraspTrial* trial = one.trial(to_string(PlannedOn::kPredicted));
    if (trial == nullptr || trial->attempts < 1 || !one.fits()) continue;
    if (std::isnan(trial->first_robustness) || trial->first_robustness < 0) continue;
    known.push_back({trial->first_robustness, trial->lifted_at_first(), one.data_set});
  }
  return known;
}

SuccessLine fit_success(const std::vector<KnownSuccess>& known) {
  constexpr int kSteps = 200;
  SuccessLine best;
  double most = -std::numeric_limits<double>::infinity();
  for (int none = 1; none < kSteps; ++none) {
    for (int all = none; all < kSteps; ++all) {
      const SuccessLine line{static_cast<double>(none) / kSteps, static_cast<double>(all) / kSteps};
      const double likelihood = log_likelihood(known, line);
      if (!(likelihood > most)) continue;
      most = likelihood;
      best = line;
    }
  }
  return best;
}

SuccessCalibration cross_validated(const std::vector<KnownSuccess>& known) {
  std::map<std::string, SuccessLine> without;
  std::vector<double> probabilities;
  for (const KnownSuccess& one : known) {
    auto found = without.find(one.object);
    if (found == without.end()) {
      std::vector<KnownSuccess> others;
      std::copy_if(known.begin(), known.end(), std::back_inserter(others),
                   [&](const KnownSuccess& other) { return other.object != one.object; });
      found = without.emplace(one.object, fit_success(others)).first;
    }
    probabilities.push_back(found->second.at(one.held));
  }
  return calibration(known, probabilities);
}

SuccessCalibration calibration_of(const std::vector<KnownSuccess>& known, const SuccessLine& line) {
  std::vector<double> probabilities;
  for (const KnownSuccess& one : known) probabilities.push_back(line.at(one.held));
  return calibration(known, probabilities);
}

}  // namespace prehend::eval
