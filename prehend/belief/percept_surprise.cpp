#include "prehend/belief/percept_surprise.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/whole_file.h"
#include "prehend/text/require.h"
#include "prehend/text/yaml_map.h"

namespace prehend::belief {
namespace {

constexpr double kDegrees = 4;            // of freedom
constexpr double kMeanBits = 1.0113;      // of a number with that noise, see percept_surprise()
constexpr double kBitsDeviation = 1.418;  // the same, (ν+1)/2 log2(e) sqrt(ψ'(ν/2) - ψ'((ν+1)/2))
constexpr double kMedian = 0.7407;        // of Student's |t|
constexpr int kSurpriseVersion = 1;
const std::string kTotal = "total";

// When motors stopped is known in full of an act that ends before the lift, unlike the total.

using Features = std::vector<PerceptFeature>;
using Chosen = std::function<bool(const PerceptFeature&)>;

// -log2 of the likelihood over the greatest there can be, of one feature.
double cost(const PerceptFeature& predicted, const PerceptFeature& perceived,
            const SurpriseModel& model) {
  if (!predicted.value || !perceived.value) return 0;
  const double share = model.shares.at(perceived.sense);
  if (perceived.touches) {
    if (*predicted.value == *perceived.value) return 0;
    return share * std::log2((1 - model.wrong_touch) / model.wrong_touch);
  }
  const double off = (*perceived.value - *predicted.value) / model.scales.at(perceived.kind);
  return share * (kDegrees + 1) / 2 * std::log2(1 + off * off / kDegrees);
}

// The features of all that is possible, and how much each costs against percepts.
class Belief {
 public:
  Belief(const PerceptForecast& predicted, const SurpriseModel& model) : model_(model) {
    for (const PossiblePercepts& one : predicted.possible) {
      features_.push_back(percept_features(one.percepts, model.touch_force));
      weights_.push_back(one.weight);
    }
  }

  std::size_t size() const { return features_.size(); }
  const Features& features(std::size_t k) const { return features_[k]; }

  double cost_of(std::size_t k, const Features& y, const Chosen& chosen) const {
    double sum = 0;
    for (std::size_t i = 0; i < y.size(); ++i) {
      if (chosen(y[i])) sum += cost(features_[k][i], y[i], model_);
    }
    return sum;
  }

  double bits(const Features& y, const Chosen& chosen) const {
    // What counts of the expectation is what was perceived: of a pad that touches nothing not
    // where, but that it does.
    double expected = 0;
    for (std::size_t j = 0; j < size(); ++j) {
      Features yj = features_[j];
      double numbers = 0;
      for (std::size_t i = 0; i < yj.size(); ++i) {
        if (!y[i].value) yj[i].value.reset();
        if (chosen(y[i]) && yj[i].value && y[i].value && !y[i].touches) {
          numbers += model_.shares.at(y[i].sense);
        }
      }
      expected += weights_[j] * (mixture(yj, chosen) + kMeanBits * numbers);
    }
    return mixture(y, chosen) - expected;
  }

  std::size_t likeliest(const Features& y) const {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < size(); ++k) {
      const double cost = cost_of(k, y, [](const auto&) { return true; }) - std::log2(weights_[k]);
      if (cost < least) best = k;
      least = std::min(least, cost);
    }
    return best;
  }

 private:
  // -log2 of the sum, the least cost taken out of it.
  double mixture(const Features& y, const Chosen& chosen) const {
    std::vector<double> costs;
    for (std::size_t k = 0; k < size(); ++k) costs.push_back(cost_of(k, y, chosen));
    const double least = *std::min_element(costs.begin(), costs.end());
    double sum = 0;
    for (std::size_t k = 0; k < size(); ++k) sum += weights_[k] * std::exp2(least - costs[k]);
    return least - std::log2(sum);
  }

  const SurpriseModel& model_;
  std::vector<Features> features_;
  std::vector<double> weights_;
};

bool same_hand(const Features& a, const Features& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.part == y.part && x.kind == y.kind;
  });
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - std::floor(at)) * (values[high] - values[low]);
}

double deviation(const std::vector<double>& values) {
  // Of the middle: what is wrong now and then belongs to the tails.
  return (quantile(values, 0.84) - quantile(values, 0.16)) / 2;
}

void fit_scales(const std::vector<KnownPercepts>& right, SurpriseModel* model) {
  std::map<std::string, std::vector<double>> off;
  for (const KnownPercepts& one : right) {
    const Belief belief(*one.predicted, *model);
    const Features y = percept_features(*one.perceived, model->touch_force);
    const Features& x = belief.features(belief.likeliest(y));
    for (std::size_t i = 0; i < y.size(); ++i) {
      if (y[i].touches || !y[i].value || !x[i].value) continue;
      off[y[i].kind].push_back(std::abs(*y[i].value - *x[i].value));
    }
  }
  for (const PerceptKind& kind : percept_kinds()) {
    const auto found = off.find(kind.name);
    if (found == off.end()) continue;
    model->scales[kind.name] = std::max(kind.least, quantile(found->second, 0.5) / kMedian);
  }
}

// What scatters more than independent numbers would is counted less.
void fit_shares(const std::vector<KnownPercepts>& right, SurpriseModel* model) {
  for (const std::string& sense : percept_senses()) {
    std::vector<double> bits;
    double numbers = 0;
    for (const KnownPercepts& one : right) {
      const Belief belief(*one.predicted, *model);
      const Features y = percept_features(*one.perceived, model->touch_force);
      bits.push_back(belief.bits(y, [&](const auto& f) { return f.sense == sense; }));
      for (const PerceptFeature& f : y) numbers += f.sense == sense && !f.touches && f.value;
    }
    const double scatter = deviation(bits);
    const double expected = kBitsDeviation * std::sqrt(numbers / static_cast<double>(right.size()));
    if (scatter > expected && expected > 0) model->shares[sense] = expected / scatter;
  }
}

// What scatters hardly at all is nothing to note for being a little rarer: not before it is as
// unlikely as an alarm is to be.
double threshold_of(const std::vector<double>& bits, double share_beyond, double false_alarms) {
  return std::max(-std::log2(false_alarms), quantile(bits, 1 - share_beyond));
}

// Each sense at the quantile of its own bits, but those by which acts are alarms all at one, the
// least at which so many acts are alarms at most, by whichever of them.
void fit_thresholds(const std::vector<KnownPercepts>& right, double false_alarms,
                    SurpriseModel* model) {
  std::map<std::string, std::vector<double>> bits;
  std::vector<PerceptSurprise> acts;
  for (const KnownPercepts& one : right) {
    acts.push_back(percept_surprise(*one.predicted, *one.perceived, *model));
    bits[kTotal].push_back(acts.back().bits);
    for (const SenseSurprise& sense : acts.back().senses) bits[sense.sense].push_back(sense.bits);
  }
  for (const auto& [name, values] : bits) {
    model->thresholds[name] = threshold_of(values, false_alarms, false_alarms);
  }
  const auto is_alarm = [&](const PerceptSurprise& act) {
    return act.bits > model->thresholds.at(kTotal) ||
           std::any_of(act.senses.begin(), act.senses.end(), [&](const SenseSurprise& sense) {
             return sense.sense == model->by_itself &&
                    sense.bits > model->thresholds.at(sense.sense);
           });
  };
  constexpr int kSteps = 100;
  for (int step = kSteps; step >= 0; --step) {
    for (const auto& [name, values] : bits) {
      if (name != kTotal && name != model->by_itself) continue;
      model->thresholds[name] = threshold_of(values, false_alarms * step / kSteps, false_alarms);
    }
    const auto alarms = static_cast<double>(std::count_if(acts.begin(), acts.end(), is_alarm));
    if (alarms <= false_alarms * static_cast<double>(acts.size())) return;
  }
}

}  // namespace

PerceptSurprise percept_surprise(const PerceptForecast& predicted, const Percepts& perceived,
                                 const SurpriseModel& model) {
  if (predicted.possible.empty()) {
    throw std::invalid_argument("percept_surprise: nothing was predicted");
  }
  check_percepts(perceived);
  const Belief belief(predicted, model);
  const Features y = percept_features(perceived, model.touch_force);
  for (std::size_t k = 0; k < belief.size(); ++k) {
    if (!same_hand(belief.features(k), y)) {
      throw std::invalid_argument("percept_surprise: percepts are of another hand than predicted");
    }
  }
  PerceptSurprise surprise;
  const auto has_sensor = [&](const Chosen& chosen) {
    return std::any_of(y.begin(), y.end(), [&](const auto& f) { return chosen(f) && f.value; });
  };
  for (const std::string& sense : percept_senses()) {
    const Chosen of_sense = [&](const PerceptFeature& f) { return f.sense == sense; };
    if (!has_sensor(of_sense)) continue;
    SenseSurprise whole{sense, "", belief.bits(y, of_sense), model.thresholds.at(sense), false};
    whole.alarm = whole.bits > whole.threshold;
    surprise.senses.push_back(whole);
    std::set<std::string> seen;
    for (const PerceptFeature& f : y) {
      if (f.sense != sense || !seen.insert(f.part).second) continue;
      const Chosen of_part = [&](const PerceptFeature& g) {
        return g.sense == sense && g.part == f.part;
      };
      if (has_sensor(of_part)) {
        surprise.parts.push_back({sense, f.part, belief.bits(y, of_part), 0, false});
      }
    }
  }
  surprise.bits = belief.bits(y, [](const auto&) { return true; });
  surprise.threshold = model.thresholds.at(kTotal);
  surprise.alarm =
      surprise.bits > surprise.threshold ||
      std::any_of(surprise.senses.begin(), surprise.senses.end(), [&](const SenseSurprise& sense) {
        return sense.alarm && sense.sense == model.by_itself;
      });
  surprise.likeliest = belief.likeliest(y);
  return surprise;
}

std::string PerceptSurprise::to_string() const {
  std::string text = fmt::format("{:.1f} bits", bits);
  std::string list;
  for (const SenseSurprise& sense : senses) {
    list += fmt::format("{}{} {:.1f}{}", list.empty() ? "" : ", ", sense.sense, sense.bits,
                        sense.alarm ? "!" : "");
  }
  return list.empty() ? text : text + " (" + list + ")";
}

SurpriseModel SurpriseModel::unfitted() {
  SurpriseModel model;
  for (const PerceptKind& kind : percept_kinds()) model.scales[kind.name] = kind.scale;
  for (const std::string& sense : percept_senses()) {
    model.shares[sense] = 1;
    model.thresholds[sense] = 30;
  }
  model.thresholds[kTotal] = 30;
  return model;
}

void SurpriseModel::validate() const {
  const text::Require require{"SurpriseModel::"};
  for (const PerceptKind& kind : percept_kinds()) {
    const auto found = scales.find(kind.name);
    require(found != scales.end() && std::isfinite(found->second) && found->second > 0,
            "scales: '" + kind.name + "' must be there and positive");
  }
  for (const std::string& sense : percept_senses()) {
    const auto found = shares.find(sense);
    require(found != shares.end() && found->second > 0 && found->second <= 1,
            "shares: '" + sense + "' must be there and in (0, 1]");
  }
  std::vector<std::string> names = percept_senses();
  names.push_back(kTotal);
  for (const std::string& name : names) {
    const auto found = thresholds.find(name);
    require(found != thresholds.end() && std::isfinite(found->second),
            "thresholds: '" + name + "' must be there and finite");
  }
  require(std::count(percept_senses().begin(), percept_senses().end(), by_itself) == 1,
          "by_itself: '" + by_itself + "' is no sense");
  require(wrong_touch > 0 && wrong_touch < 0.5, "wrong_touch must be in (0, 0.5)");
  require(std::isfinite(touch_force) && touch_force > 0, "touch_force must be positive");
}

SurpriseModel fit_surprise(const std::vector<KnownPercepts>& right, double false_alarms,
                           const std::string& by_itself) {
  const text::Require require{"fit_surprise: "};
  constexpr std::size_t kLeastKnown = 20;
  require(right.size() >= kLeastKnown, "there must be at least 20 right predictions");
  require(false_alarms > 0 && false_alarms < 0.5, "false_alarms must be in (0, 0.5)");
  SurpriseModel model = SurpriseModel::unfitted();
  model.by_itself = by_itself;
  model.validate();
  constexpr int kRounds = 3;  // which possible percept is the likeliest depends on the scales
  for (int round = 0; round < kRounds; ++round) fit_scales(right, &model);
  fit_shares(right, &model);
  fit_thresholds(right, false_alarms, &model);
  return model;
}

void PerceptSurprise::forget_thresholds() {
  threshold = 0;
  alarm = false;
  for (std::vector<SenseSurprise>* list : {&senses, &parts}) {
    for (SenseSurprise& one : *list) {
      one.threshold = 0;
      one.alarm = false;
    }
  }
}

SurpriseModel SurpriseModel::load(const std::filesystem::path& file) {
  text::YamlMap map(text::load_yaml_map(file), file, "percept surprise");
  SurpriseModel model = unfitted();
  int version = 0;
  map.read("version", version);
  const std::string mend = "Make it anew: eval_belief --surprise --fit FILE";
  if (version != kSurpriseVersion) {
    map.fail("version", fmt::format("is {}", version),
             fmt::format("This program reads {}. {}", kSurpriseVersion, mend));
  }
  map.read("wrong_touch", model.wrong_touch);
  map.read("touch_force", model.touch_force);
  map.read("by_itself", model.by_itself);
  map.read("hand", model.hand);
  const auto read = [&](const std::string& key, std::map<std::string, double>& values) {
    const YAML::Node node = map.child(key);
    if (!node.IsDefined()) map.fail(key, "is missing", mend);
    text::YamlMap child(node, file, key);
    for (auto& [name, value] : values) {
      value = std::numeric_limits<double>::quiet_NaN();
      child.read(name, value);
    }
    child.finish();
  };
  read("scales", model.scales);
  read("shares", model.shares);
  read("thresholds", model.thresholds);
  map.finish();
  try {
    model.validate();
  } catch (const std::invalid_argument& error) {
    throw geometry::InputError(file.string() + ": " + error.what(), mend);
  }
  return model;
}

SurpriseModel SurpriseModel::load_for(const std::filesystem::path& path, const std::string& hand) {
  if (!std::filesystem::is_directory(path)) return load(path);
  const std::filesystem::path own = path / (hand + ".yaml");
  return load(std::filesystem::exists(own) ? own : path / "sdh2.yaml");
}

void SurpriseModel::save(const std::filesystem::path& file, const std::string& made_by) const {
  validate();
  std::string text =
      "# How percepts of grasps scatter about predicted ones, and what is a surprise\n"
      "# (prehend/belief/percept_surprise.h).\n";
  std::istringstream lines(made_by);
  for (std::string line; std::getline(lines, line);) text += "# " + line + "\n";
  text += fmt::format("version: {}\nwrong_touch: {:.6g}\ntouch_force: {:.6g}\n", kSurpriseVersion,
                      wrong_touch, touch_force);
  text += "by_itself: " + by_itself + "\n";
  if (!hand.empty()) text += "hand: " + hand + "\n";
  const auto write = [&](const char* key, const std::map<std::string, double>& values) {
    text += fmt::format("{}:\n", key);
    for (const auto& [name, value] : values) text += fmt::format("  {}: {:.6g}\n", name, value);
  };
  write("scales", scales);
  write("shares", shares);
  write("thresholds", thresholds);
  geometry::write_whole_file(file, text, "The model of surprise");
}

}  // namespace prehend::belief
