#include "eval/belief/prior_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>
#include <Eigen/Core>

namespace prehend::eval {
namespace {

using belief::PriorTerms;
using belief::ShapePrior;
using shape::CompletionMethod;

constexpr double kNear = 0.001;    // m
constexpr double kRidge = 1e-4;    // of a weight's square
constexpr double kSteepest = 100;  // of the scales' inverses
constexpr int kFolds = 5;

// In these the log of a weight is linear.
enum Weight { kVote, kScore, kRotation, kExtrusion, kConvexHull, kBelow, kLost, kWeights };
using Weights = Eigen::Matrix<double, kWeights, 1>;

Weights weights_of(const ShapePrior& prior) {
  Weights weights;
  weights << 1 / prior.vote_scale, 1 / prior.score_scale, prior.rotation, prior.extrusion,
      prior.convex_hull, prior.mirrored_below, prior.lost;
  return weights;
}

ShapePrior prior_of(const Weights& weights) {
  ShapePrior prior;
  prior.vote_scale = 1 / weights[kVote];
  prior.score_scale = 1 / weights[kScore];
  prior.rotation = weights[kRotation];
  prior.extrusion = weights[kExtrusion];
  prior.convex_hull = weights[kConvexHull];
  prior.mirrored_below = weights[kBelow];
  prior.lost = weights[kLost];
  return prior;
}

// The derivative of log_prior() by each of the weights, which it is linear in.
Weights terms_of(const PriorTerms& terms) {
  Weights result = Weights::Zero();
  result[kLost] = -terms.lost;
  switch (terms.method) {
    case CompletionMethod::kMirror:
    case CompletionMethod::kRefusedMirror:
      result[kVote] = -terms.worse;
      result[kBelow] = terms.mirrored_below ? 1 : 0;
      break;
    case CompletionMethod::kRotation:
      result[kScore] = -terms.worse;
      result[kRotation] = 1;
      break;
    case CompletionMethod::kExtrusion:
      result[kScore] = -terms.worse;
      result[kExtrusion] = 1;
      break;
    case CompletionMethod::kConvexHull:
      result[kScore] = -terms.worse;
      result[kConvexHull] = 1;
      break;
  }
  return result;
}

struct Scored {
  double log_likelihood = 0;
  Weights gradient = Weights::Zero();
  double unseen = 0;  // m, of the likeliest
};

Scored score_of(const std::vector<TriedShape>& shapes, const Weights& weights) {
  double least = std::numeric_limits<double>::infinity();
  for (const TriedShape& shape : shapes) least = std::min(least, shape.unseen);
  double most = -std::numeric_limits<double>::infinity();
  Scored scored;
  std::vector<double> logs;
  for (const TriedShape& shape : shapes) {
    logs.push_back(terms_of(shape.terms).dot(weights));
    if (logs.back() > most) scored.unseen = shape.unseen;
    most = std::max(most, logs.back());
  }
  double all = 0, near = 0;
  Weights of_all = Weights::Zero(), of_near = Weights::Zero();
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const double weight = std::exp(logs[i] - most);
    const double nearness = std::exp(-(shapes[i].unseen - least) / kNear);
    const Weights terms = terms_of(shapes[i].terms);
    all += weight;
    near += weight * nearness;
    of_all += weight * terms;
    of_near += weight * nearness * terms;
  }
  near = std::max(near, 1e-300);
  scored.log_likelihood = std::log(near / all);
  scored.gradient = of_near / near - of_all / all;
  return scored;
}

Scored mean_of(const std::vector<BeliefCase>& cases, const Weights& weights) {
  Scored mean;
  double count = 0;
  for (const BeliefCase& one : cases) {
    if (one.shapes.empty()) continue;
    const Scored scored = score_of(one.shapes, weights);
    mean.log_likelihood += scored.log_likelihood;
    mean.gradient += scored.gradient;
    mean.unseen += scored.unseen;
    ++count;
  }
  if (count == 0) return mean;
  return {mean.log_likelihood / count, mean.gradient / count, mean.unseen / count};
}

Weights allowed(Weights weights) {
  for (const Weight one : {kVote, kScore}) weights[one] = std::clamp(weights[one], 0.1, kSteepest);
  weights[kLost] = std::max(0.0, weights[kLost]);
  return weights;
}

std::string line(const char* name, const PriorScore& score) {
  return fmt::format("  {:<10} log likelihood {:7.3f}, unseen error of the likeliest {:.2f} mm\n",
                     name, score.log_likelihood, 1e3 * score.unseen);
}

}  // namespace

PriorScore score(const ShapePrior& prior, const std::vector<BeliefCase>& cases) {
  const Scored mean = mean_of(cases, weights_of(prior));
  return {mean.log_likelihood, mean.unseen};
}

ShapePrior fitted_prior(const std::vector<BeliefCase>& cases) {
  Weights weights = weights_of({});
  const auto value = [&](const Weights& at) {
    return mean_of(cases, at).log_likelihood - kRidge * at.squaredNorm();
  };
  double step = 1, best = value(weights);
  while (step > 1e-6) {
    const Weights gradient = mean_of(cases, weights).gradient - 2 * kRidge * weights;
    const Weights next = allowed(weights + step * gradient);
    const double there = value(next);
    if (!(there > best + 1e-12)) {
      step *= 0.5;
      continue;
    }
    weights = next;
    best = there;
    step *= 1.5;
  }
  return prior_of(weights);
}

std::string prior_fit_text(const std::vector<BeliefCase>& cases) {
  std::map<std::string, int> folds;
  for (const BeliefCase& one : cases) folds.emplace(one.data_set, 0);
  int next = 0;
  for (auto& [name, fold] : folds) fold = next++ % kFolds;
  PriorScore others, shipped;
  double count = 0;
  for (int fold = 0; fold < kFolds; ++fold) {
    std::vector<BeliefCase> fit, test;
    for (const BeliefCase& one : cases) {
      if (!one.shapes.empty()) (folds.at(one.data_set) == fold ? test : fit).push_back(one);
    }
    if (fit.empty() || test.empty()) continue;
    const auto add = [&](const PriorScore& one, PriorScore* sum) {
      sum->log_likelihood += one.log_likelihood * static_cast<double>(test.size());
      sum->unseen += one.unseen * static_cast<double>(test.size());
    };
    add(score(fitted_prior(fit), test), &others);
    add(score({}, test), &shipped);
    count += static_cast<double>(test.size());
  }
  if (count == 0) return "Too few objects to fit the shapes' weights.\n";
  for (PriorScore* sum : {&others, &shipped}) {
    sum->log_likelihood /= count;
    sum->unseen /= count;
  }
  const ShapePrior fitted = fitted_prior(cases);
  std::string text = fmt::format("Weights of shapes before a touch ({} views):\n", count);
  const std::pair<const char*, double ShapePrior::*> knobs[] = {
      {"vote_scale", &ShapePrior::vote_scale},
      {"score_scale", &ShapePrior::score_scale},
      {"rotation", &ShapePrior::rotation},
      {"extrusion", &ShapePrior::extrusion},
      {"convex_hull", &ShapePrior::convex_hull},
      {"mirrored_below", &ShapePrior::mirrored_below},
      {"lost", &ShapePrior::lost}};
  for (const auto& [name, knob] : knobs) {
    text += fmt::format("  {:<15} shipped {:7.3f}, fitted {:7.3f}\n", name, ShapePrior().*knob,
                        fitted.*knob);
  }
  text += line("shipped", shipped) + line("fitted", score(fitted, cases));
  return text + "of objects that they were not fitted to:\n" + line("fitted", others);
}

}  // namespace prehend::eval
