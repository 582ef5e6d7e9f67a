#include "prehend/touch/imprint_memory.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include <fmt/format.h>

namespace prehend::touch {
namespace {

constexpr double kLeastSpread = 0.15;  // of the excess, where few presses say little of it
// The mean excess of presses of what was learned: they lie where they fit best. Of a face that was
// taught by one press, which has no others to be laid on.
constexpr double kUsualExcess = -1.8;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Medians: one press that came to lie wrongly must not make the face look vague.
double own_excess(const LearnedImprint& face) {
  if (face.own_fits().empty()) return kUsualExcess;
  std::vector<double> values;
  for (const ImprintFit& fit : face.own_fits()) values.push_back(fit.excess());
  return median(std::move(values));
}

}  // namespace

ImprintMemory::ImprintMemory(const ImprintOptions& options, double patience)
    : options_(options), patience_(patience) {
  if (!(std::isfinite(patience) && patience > 0)) {
    throw std::invalid_argument("ImprintMemory: patience must be positive");
  }
}

void ImprintMemory::teach(const std::string& name, const std::vector<Imprint>& presses) {
  faces_.insert_or_assign(name, LearnedImprint(presses, options_));
}

void ImprintMemory::teach(const std::string& name, LearnedImprint face) {
  faces_.insert_or_assign(name, std::move(face));
}

bool ImprintMemory::forget(const std::string& name) { return faces_.erase(name) > 0; }

double ImprintMemory::spread() const {
  std::vector<double> values;
  for (const auto& [name, face] : faces_) {
    const double middle = own_excess(face);
    for (const ImprintFit& fit : face.own_fits()) values.push_back(std::abs(fit.excess() - middle));
  }
  constexpr double kOfNormal = 1.4826;  // standard deviation over the median of distances
  return values.empty() ? kLeastSpread : std::max(kLeastSpread, kOfNormal * median(values));
}

Recognised ImprintMemory::ask(const std::vector<Imprint>& presses) const {
  std::vector<Fits> all;
  for (const Imprint& press : presses) all.push_back(fits(press));
  return judge(all);
}

ImprintMemory::Fits ImprintMemory::fits(const Imprint& press) const {
  Fits fits;
  for (const auto& [name, face] : faces_) fits.emplace(name, face.fit(press));
  return fits;
}

Recognised ImprintMemory::judge(const std::vector<Fits>& presses) const {
  if (presses.empty()) throw std::invalid_argument("ImprintMemory: asked without a press");
  const double spread_of_all = spread();
  std::vector<std::pair<double, Candidate>> found;  // by the sum of misfits
  for (const auto& [name, face] : faces_) {
    double misfit = 0, excess = 0;
    for (const Fits& press : presses) {
      const auto of_face = press.find(name);
      if (of_face == press.end()) {
        throw std::invalid_argument("ImprintMemory: no fit of a press on '" + name + "'");
      }
      const ImprintFit& fit = of_face->second;
      misfit += fit.misfit;
      excess += fit.excess() / static_cast<double>(presses.size());
    }
    found.push_back({misfit, {name, (excess - own_excess(face)) / (patience_ * spread_of_all)}});
  }
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  Recognised answer;
  for (auto& [misfit, candidate] : found) answer.candidates.push_back(std::move(candidate));
  if (found.empty()) {
    answer.reason = "nothing was taught";
  } else if (const Candidate& best = answer.candidates.front(); best.misfit <= 1) {
    answer.name = best.name;
  } else {
    answer.reason = fmt::format("it is likest '{}', but fits {:.1f} times worse than it may",
                                best.name, best.misfit);
  }
  return answer;
}

}  // namespace prehend::touch
