#include "prehend/touch/imprint.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "prehend/text/require.h"

namespace prehend::touch {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
constexpr std::size_t kRefined = 6;  // of the coarse search's best
constexpr double kLeast = 0.02;      // likelihood: one texel that is wrong refuses nothing
constexpr double kLever = 0.01;      // m, at which turning counts as shifting
constexpr int kRounds = 3;           // of halving the steps
// Shares of a pressed texel's pressure, round half of it: what foam spreads to a texel that is free
// is about the first at most, what it leaves on one that is pressed is more than the second.
constexpr double kFree = 0.2, kPressed = 0.7;

// The pressure of texels that are pressed whole: the median of those above half of it.
double whole_pressure(std::vector<double> pressures) {
  constexpr int kTimes = 4;  // it settles soon
  double whole = 0;
  for (int round = 0; round < kTimes; ++round) {
    std::erase_if(pressures, [&](double pressure) { return pressure <= whole / 2; });
    const auto middle = pressures.begin() + static_cast<std::ptrdiff_t>(pressures.size() / 2);
    std::nth_element(pressures.begin(), middle, pressures.end());
    whole = *middle;
  }
  return whole;
}

Vector2d middle_of_free(const Imprint& press) {
  Vector2d sum = Vector2d::Zero();
  double weight = 0;
  for (std::size_t i = 0; i < press.places.size(); ++i) {
    sum += (1 - press.pressed[i]) * press.places[i];
    weight += 1 - press.pressed[i];
  }
  return weight > 0 ? Vector2d(sum / weight) : Vector2d::Zero();
}

}  // namespace

std::optional<Imprint> imprint_of(const FeltPad& pad, const FeltTexels& felt, int least_touched) {
  std::vector<double> pressures;
  for (std::size_t i = 0; i < felt.force.size(); ++i) {
    if (felt.force[i] > 0) pressures.push_back(felt.force[i] / pad.layout.area(i));
  }
  if (static_cast<int>(pressures.size()) < std::max(1, least_touched)) return std::nullopt;
  const double whole = whole_pressure(std::move(pressures));
  Imprint imprint;
  for (std::size_t i = 0; i < felt.force.size(); ++i) {
    if (felt.state[i] == Texel::kUnreadable) continue;
    imprint.places.emplace_back(pad.layout.x[i], pad.layout.y[i]);
    const double share = felt.force[i] / pad.layout.area(i) / whole;
    imprint.pressed.push_back(std::clamp((share - kFree) / (kPressed - kFree), 0.0, 1.0));
  }
  return imprint;
}

LearnedImprint::LearnedImprint(const std::vector<Imprint>& presses, const ImprintOptions& options)
    : options_(options) {
  const text::Require require{"ImprintOptions."};
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  require(positive(options.cell) && positive(options.half_size) &&
              options.half_size / options.cell <= 500,
          "cell and half_size must be positive, at most 500 cells from the middle");
  require(positive(options.blur), "blur must be positive");
  require(positive(options.contrast), "contrast must be positive");
  require(positive(options.doubt), "doubt must be positive");
  require(positive(options.search_step), "search_step must be positive");
  require(std::isfinite(options.farthest_shift) && options.farthest_shift >= 0,
          "farthest_shift must not be negative");
  require(options.sweeps >= 1 && options.starts >= 1, "sweeps and starts must be 1 or more");
  if (presses.empty()) throw std::invalid_argument("LearnedImprint: without a press");
  cells_ = 2 * static_cast<int>(std::lround(options.half_size / options.cell)) + 1;

  // The one whose pattern is most in the middle is cut least by the pad's edge: it comes first.
  std::vector<Imprint> sorted = presses;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Imprint& a, const Imprint& b) {
    return middle_of_free(a).norm() < middle_of_free(b).norm();
  });
  // What comes out depends on where it begins; the beginning whose presses fit one another best
  // counts.
  double least = std::numeric_limits<double>::infinity();
  std::vector<ImprintPlacement> placements;
  std::vector<ImprintFit> fits;
  std::vector<Imprint> kept;
  const auto starts =
      std::min<std::size_t>(static_cast<std::size_t>(options.starts), sorted.size());
  for (std::size_t start = 0; start < starts; ++start) {
    std::vector<ImprintPlacement> laid = lay_over(sorted);
    double sum = 0;
    for (const ImprintFit& fit : own_fits_) sum += fit.misfit;
    if (sum < least) {
      least = sum;
      placements = std::move(laid);
      fits = own_fits_;
      kept = sorted;
    }
    // Another one first, the others in their order.
    if (start + 1 < starts) std::rotate(sorted.begin(), sorted.begin() + 1, sorted.end());
  }
  own_fits_ = fits;
  build(kept, placements, kNone);
}

std::vector<ImprintPlacement> LearnedImprint::lay_over(const std::vector<Imprint>& presses) {
  std::vector<ImprintPlacement> placements{{0, middle_of_free(presses[0])}};
  build(presses, placements, kNone);
  while (placements.size() < presses.size()) {
    placements.push_back(best(presses[placements.size()]).placement);
    build(presses, placements, kNone);
  }
  for (int sweep = 0; sweep < options_.sweeps && presses.size() > 1; ++sweep) {
    own_fits_.clear();
    for (std::size_t k = 0; k < presses.size(); ++k) {
      build(presses, placements, k);
      const Found found = best(presses[k]);
      placements[k] = found.placement;
      own_fits_.push_back(judged(presses[k], found));
    }
  }
  return placements;
}

void LearnedImprint::build(const std::vector<Imprint>& presses,
                           const std::vector<ImprintPlacement>& placements, std::size_t left_out) {
  const auto count = static_cast<std::size_t>(cells_) * cells_;
  map_.assign(count, 0);
  weight_.assign(count, 0);
  const double blur = options_.blur / options_.cell;
  const int reach = static_cast<int>(std::ceil(3 * blur));
  const int half = cells_ / 2;
  for (std::size_t k = 0; k < placements.size(); ++k) {
    if (k == left_out) continue;
    const double c = std::cos(placements[k].turn), s = std::sin(placements[k].turn);
    for (std::size_t i = 0; i < presses[k].places.size(); ++i) {
      const Vector2d d = presses[k].places[i] - placements[k].shift;
      const double x = (c * d.x() - s * d.y()) / options_.cell + half;
      const double y = (s * d.x() + c * d.y()) / options_.cell + half;
      const int column = static_cast<int>(std::lround(x)), row = static_cast<int>(std::lround(y));
      for (int r = std::max(0, row - reach); r <= std::min(cells_ - 1, row + reach); ++r) {
        for (int q = std::max(0, column - reach); q <= std::min(cells_ - 1, column + reach); ++q) {
          const double square = (q - x) * (q - x) + (r - y) * (r - y);
          const double weight = std::exp(-square / (2 * blur * blur));
          weight_[r * cells_ + q] += weight;
          map_[r * cells_ + q] += weight * presses[k].pressed[i];
        }
      }
    }
  }
  if_pressed_.resize(count);
  if_free_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double pressed = map_[i] + options_.doubt / 2;
    const double free = weight_[i] + options_.doubt - pressed;
    const double likelihood = 1 / (1 + std::pow(std::max(0.0, free) / pressed, options_.contrast));
    map_[i] = std::clamp(likelihood, kLeast, 1 - kLeast);
    if_pressed_[i] = static_cast<float>(-std::log(map_[i]));
    if_free_[i] = static_cast<float>(-std::log(1 - map_[i]));
  }
}

std::size_t LearnedImprint::cell_of(const Vector2d& p_pad,
                                    const ImprintPlacement& placement) const {
  const double c = std::cos(placement.turn), s = std::sin(placement.turn);
  const Vector2d d = (p_pad - placement.shift) / options_.cell;
  const auto cell = [&](double x) {
    return std::clamp(static_cast<int>(x + cells_ / 2 + 0.5), 0, cells_ - 1);
  };
  return static_cast<std::size_t>(cell(s * d.x() + c * d.y())) * cells_ +
         cell(c * d.x() - s * d.y());
}

double LearnedImprint::cost(const Imprint& press, const ImprintPlacement& placement,
                            double enough) const {
  const double c = std::cos(placement.turn) / options_.cell;
  const double s = std::sin(placement.turn) / options_.cell;
  const double middle = cells_ / 2 + 0.5;
  double sum = 0;
  for (std::size_t i = 0; i < press.places.size() && sum < enough; ++i) {
    const double dx = press.places[i].x() - placement.shift.x();
    const double dy = press.places[i].y() - placement.shift.y();
    const int column = std::clamp(static_cast<int>(c * dx - s * dy + middle), 0, cells_ - 1);
    const int row = std::clamp(static_cast<int>(s * dx + c * dy + middle), 0, cells_ - 1);
    const int at = row * cells_ + column;
    sum += press.pressed[i] * if_pressed_[at] + (1 - press.pressed[i]) * if_free_[at];
  }
  return sum;
}

LearnedImprint::Found LearnedImprint::refined(const Imprint& press, Found from) const {
  double step = options_.search_step / 2;
  for (int round = 0; round < kRounds; ++round, step /= 2) {
    bool better = true;
    while (better) {
      better = false;
      const ImprintPlacement at = from.placement;
      for (const int turn : {-1, 0, 1}) {
        for (const int x : {-1, 0, 1}) {
          for (const int y : {-1, 0, 1}) {
            const ImprintPlacement other{at.turn + turn * step / kLever,
                                         at.shift + step * Vector2d(x, y)};
            const double value = cost(press, other, from.cost);
            if (value >= from.cost - 1e-9) continue;
            from = {value, other};
            better = true;
          }
        }
      }
    }
  }
  return from;
}

LearnedImprint::Found LearnedImprint::best(const Imprint& press) const {
  Vector2d low = Vector2d::Zero(), high = Vector2d::Zero();  // of the places
  for (const Vector2d& p : press.places) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  // The middle of what was learned lies on the pad, and not farther than is looked for.
  const double far = options_.farthest_shift;
  low = low.cwiseMax(Vector2d::Constant(-far));
  high = high.cwiseMin(Vector2d::Constant(far));
  const double step = options_.search_step;
  const int turns = static_cast<int>(std::ceil(2 * std::numbers::pi * kLever / step));
  std::vector<Found> found;  // the best turns, the best first
  for (int k = 0; k < turns; ++k) {
    const bool full = found.size() == kRefined;
    Found of_turn{full ? found.back().cost : std::numeric_limits<double>::infinity(), {}};
    bool better = false;
    for (double x = low.x(); x <= high.x() + step / 2; x += step) {
      for (double y = low.y(); y <= high.y() + step / 2; y += step) {
        const ImprintPlacement placement{2 * std::numbers::pi * k / turns, {x, y}};
        const double value = cost(press, placement, of_turn.cost);
        if (value >= of_turn.cost) continue;
        of_turn = {value, placement};
        better = true;
      }
    }
    if (!better) continue;
    if (full) found.pop_back();
    found.insert(std::upper_bound(found.begin(), found.end(), of_turn,
                                  [](const Found& a, const Found& b) { return a.cost < b.cost; }),
                 of_turn);
  }
  Found best{std::numeric_limits<double>::infinity(), {}};
  for (const Found& turn : found) {
    const Found one = refined(press, turn);
    if (one.cost < best.cost) best = one;
  }
  return best;
}

ImprintFit LearnedImprint::judged(const Imprint& press, const Found& found) const {
  ImprintFit fit{found.cost, 0, 0, found.placement};
  for (const Vector2d& place : press.places) {
    const std::size_t at = cell_of(place, found.placement);
    const double p = map_[at], odds = if_pressed_[at] - if_free_[at];
    fit.expected += p * if_pressed_[at] + (1 - p) * if_free_[at];
    fit.variance += p * (1 - p) * odds * odds;
  }
  return fit;
}

ImprintFit LearnedImprint::fit(const Imprint& press) const { return judged(press, best(press)); }

double ImprintFit::excess() const {
  return variance > 0 ? (misfit - expected) / std::sqrt(variance) : 0;
}

}  // namespace prehend::touch
