#include "prehend/planning/decision.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "prehend/grasp/uncertainty.h"
#include "prehend/text/require.h"

namespace prehend::planning {
namespace {

using Weights = std::vector<double>;

// Of the normal distribution, in standard deviations, exact to the fifth power.
struct Node {
  double at, weight;
};
constexpr std::array<Node, 3> kGaussHermite{
    {{-1.7320508075688772, 1.0 / 6}, {0, 2.0 / 3}, {1.7320508075688772, 1.0 / 6}}};

class Decider {
 public:
  Decider(const std::vector<GraspChances>& grasps, bool jaws, const DecisionOptions& options)
      : grasps_(grasps),
        options_(options),
        deviation_(jaws ? options.stop_deviation_length : options.stop_deviation_angle) {}

  // Of what is worth most of grasping and giving up.
  double best(const Weights& weights, int attempts) const {
    double most = 0;
    for (std::size_t g = 0; attempts > 0 && g < grasps_.size(); ++g) {
      most = std::max(most, grasping(g, weights, attempts));
    }
    return most;
  }

  double grasping(std::size_t g, const Weights& weights, int attempts) const {
    const double success = success_of(grasps_[g], weights, options_);
    const double now =
        success * options_.value - options_.attempt - (1 - success) * options_.failure;
    if (attempts <= 1 || success >= 1) return now;
    Weights failed = weights;
    for (std::size_t k = 0; k < failed.size(); ++k) failed[k] *= 1 - on_shape(g, k, success);
    return now + (1 - success) * best(normalized(std::move(failed)), attempts - 1);
  }

  // The highest probability that is to be had.
  double success(const Weights& weights) const {
    double most = 0;
    for (const GraspChances& grasp : grasps_) {
      most = std::max(most, success_of(grasp, weights, options_));
    }
    return most;
  }

  bool tells(std::size_t g) const { return !grasps_[g].stops.empty(); }

  // Expectation of `what` of the shapes' weights after touching there.
  template <class What>
  double after_touch(std::size_t g, const Weights& weights, const What& what) const {
    return after_stop([&](std::size_t k, std::size_t j) { return difference(g, k, j); }, weights,
                      what);
  }

  // The same after a probe that shapes stop after these ways [m].
  template <class What>
  double after_probe(const std::vector<double>& stops, const Weights& weights,
                     const What& what) const {
    const auto apart = [&](std::size_t k, std::size_t j) {
      return std::min(kPlain, std::abs(stops[k] - stops[j]) / options_.stop_deviation_probe);
    };
    return after_stop(apart, weights, what);
  }

  /// The same after a look that shows the shapes so far apart [m].
  template <class What>
  double after_look(const Eigen::MatrixXd& shown_apart, const Weights& weights,
                    const What& what) const {
    const auto apart = [&](std::size_t k, std::size_t j) {
      return std::min(kPlain,
                      shown_apart(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(j)) /
                          options_.look_deviation);
    };
    return after_stop(apart, weights, what);
  }

 private:
  static constexpr double kPlain = 10;  // closing on air is told from a touch

  // `difference` of where it stops on two shapes, in standard deviations.
  template <class Difference, class What>
  static double after_stop(const Difference& difference, const Weights& weights, const What& what) {
    double sum = 0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      if (weights[k] == 0) continue;
      for (const Node& node : kGaussHermite) {
        Weights then = weights;
        for (std::size_t j = 0; j < then.size(); ++j) {
          // Along the line between the two, where all that tells them apart is.
          const double apart = difference(k, j) + node.at;
          then[j] *= std::exp(-0.5 * (apart * apart - node.at * node.at));
        }
        sum += weights[k] * node.weight * what(normalized(std::move(then)));
      }
    }
    return sum;
  }

  static Weights normalized(Weights weights) {
    double sum = 0;
    for (const double weight : weights) sum += weight;
    for (double& weight : weights) weight = sum > 0 ? weight / sum : 1.0 / weights.size();
    return weights;
  }

  double on_shape(std::size_t g, std::size_t k, double otherwise) const {
    const double held = grasps_[g].held[k];
    return std::isnan(held) ? otherwise : success_of(held, options_);
  }

  // Of where the hand stops on two shapes, in standard deviations of a motor.
  double difference(std::size_t g, std::size_t k, std::size_t j) const {
    const Eigen::VectorXd &a = grasps_[g].stops[k], &b = grasps_[g].stops[j];
    if (k == j) return 0;
    if (a.size() != b.size()) return kPlain;
    if (a.size() == 0) return 0;
    return std::min(kPlain, (a - b).norm() / deviation_);
  }

  const std::vector<GraspChances>& grasps_;
  const DecisionOptions& options_;
  double deviation_;
};

void check(const std::vector<GraspChances>& grasps, const Weights& weights,
           const std::vector<double>& probe, const LookChances& look) {
  const text::Require require{"decide: "};
  const auto shapes = static_cast<Eigen::Index>(weights.size());
  require(look.apart.size() == 0 || (look.apart.rows() == shapes && look.apart.cols() == shapes),
          "the look is of other shapes than the weights");
  require(look.apart.allFinite() && (look.apart.array() >= 0).all(),
          "how far a look shows shapes apart must not be negative");
  require(probe.empty() || probe.size() == weights.size(),
          "the probe is of other shapes than the weights");
  for (const double stop : probe) require(std::isfinite(stop), "a probe's stop is not finite");
  double sum = 0;
  for (const double weight : weights) {
    require(std::isfinite(weight) && weight >= 0, "weights must not be negative");
    sum += weight;
  }
  require(std::abs(sum - 1) < 1e-6, "weights must be 1 together");
  for (const GraspChances& grasp : grasps) {
    require(grasp.held.size() == weights.size(), "a grasp is of other shapes than the weights");
    require(grasp.stops.empty() || grasp.stops.size() == weights.size(),
            "a grasp's stops are of other shapes than the weights");
    for (const double held : grasp.held) {
      require(std::isnan(held) || (held >= 0 && held <= 1), "a share held is outside 0 to 1");
    }
  }
}

}  // namespace

const char* to_string(Act act) {
  switch (act) {
    case Act::kGrasp:
      return "grasp";
    case Act::kTouch:
      return "touch";
    case Act::kLook:
      return "look";
    case Act::kGiveUp:
      return "give up";
    case Act::kProbe:
      return "probe";
  }
  return "unknown";
}

void DecisionOptions::validate() const {
  const text::Require require{"DecisionOptions."};
  knobs(*this, text::CheckKnobs{require.of});
  look_knobs(*this, text::CheckKnobs{require.of});
  require(std::isfinite(look_deviation) && look_deviation > 0, "look_deviation must be positive");
  require(attempts >= 1, "attempts must be at least 1");
  require(success_of_all >= success_of_none, "success_of_all must not be below success_of_none");
  require(std::isfinite(stop_deviation_angle) && stop_deviation_angle > 0,
          "stop_deviation_angle must be positive");
  require(std::isfinite(stop_deviation_probe) && stop_deviation_probe > 0,
          "stop_deviation_probe must be positive");
  require(std::isfinite(stop_deviation_length) && stop_deviation_length > 0,
          "stop_deviation_length must be positive");
}

GraspChances chances_of(const grasp::Grasp& grasp) {
  return {grasp.held_on_shapes, grasp.stops_on_shapes};
}

double success_of(double held, const DecisionOptions& options) {
  return options.success_of_none + held * (options.success_of_all - options.success_of_none);
}

double success_of(const GraspChances& grasp, const std::vector<double>& weights,
                  const DecisionOptions& options) {
  return success_of(grasp::mean_share(grasp.held, weights).value_or(0), options);
}

std::vector<Choice> decide(const std::vector<GraspChances>& grasps,
                           const std::vector<double>& weights, bool jaws,
                           const DecisionOptions& options, const std::vector<double>& probe,
                           const LookChances& look) {
  options.validate();
  check(grasps, weights, probe, look);
  const Decider decider(grasps, jaws, options);
  std::vector<Choice> choices;
  for (std::size_t g = 0; g < grasps.size(); ++g) {
    const int index = static_cast<int>(g);
    if (g == 0) {
      Choice grasp{Act::kGrasp, index, success_of(grasps[g], weights, options),
                   decider.grasping(g, weights, options.attempts), ""};
      grasp.text = fmt::format("grasp it now: lifted with {:.2f}, worth {:.0f} s", grasp.success,
                               grasp.worth);
      choices.push_back(std::move(grasp));
    }
    if (options.touches == 0 || !decider.tells(g)) continue;
    Choice touch{Act::kTouch, index, 0, 0, ""};
    touch.success =
        decider.after_touch(g, weights, [&](const Weights& then) { return decider.success(then); });
    touch.worth = decider.after_touch(g, weights, [&](const Weights& then) {
      return decider.best(then, options.attempts);
    }) - options.touch;
    touch.text = fmt::format("feel it with grasp {} first: lifted with {:.2f} then, worth {:.0f} s",
                             g, touch.success, touch.worth);
    choices.push_back(std::move(touch));
  }
  if (options.touches > 0 && !probe.empty() && !grasps.empty()) {
    Choice first{Act::kProbe, -1, 0, 0, ""};
    first.success = decider.after_probe(probe, weights,
                                        [&](const Weights& then) { return decider.success(then); });
    first.worth = decider.after_probe(probe, weights, [&](const Weights& then) {
      return decider.best(then, options.attempts);
    }) - options.touch;
    first.text =
        fmt::format("touch it with one fingertip first: lifted with {:.2f} then, worth {:.0f} s",
                    first.success, first.worth);
    choices.push_back(std::move(first));
  }
  choices.push_back({Act::kGiveUp, -1, 0, 0, "leave it: worth 0 s"});
  const bool looks = look.apart.size() > 0 && options.looks > 0;
  if (looks && !grasps.empty()) {
    Choice first{Act::kLook, -1, 0, 0, ""};
    first.success = decider.after_look(look.apart, weights,
                                       [&](const Weights& then) { return decider.success(then); });
    first.worth = decider.after_look(look.apart, weights, [&](const Weights& then) {
      return decider.best(then, options.attempts);
    }) - options.look;
    first.text = fmt::format("look at it from {} first: lifted with {:.2f} then, worth {:.0f} s",
                             look.from, first.success, first.worth);
    choices.push_back(std::move(first));
  }
  // What is as good as what is cheaper to do comes after it.
  std::stable_sort(choices.begin(), choices.end(),
                   [](const Choice& a, const Choice& b) { return a.worth > b.worth; });
  if (choices.front().act == Act::kGiveUp && choices.size() > 1) {
    choices.front().text = "leave it: " + choices[1].text;
  }
  if (!looks && weights.size() > 1 && !grasps.empty()) {
    Choice told{Act::kLook, -1, 0, 0, ""};
    for (std::size_t k = 0; k < weights.size(); ++k) {
      Weights known(weights.size(), 0);
      known[k] = 1;
      told.success += weights[k] * decider.success(known);
      told.worth += weights[k] * decider.best(known, options.attempts);
    }
    told.text = fmt::format(
        "a look that tells its shape: lifted with {:.2f} then, worth {:.0f} s, but {}",
        told.success, told.worth, options.looks > 0 ? look.problem : "it was looked at enough");
    choices.push_back(std::move(told));
  }
  return choices;
}

std::vector<Choice> decide_on(const surface::ObjectModel& object,
                              const std::vector<const grasp::Grasp*>& grasps, bool jaws,
                              const DecisionOptions& options, const std::vector<double>& probe,
                              const LookChances& look) {
  std::vector<GraspChances> chances;
  for (const grasp::Grasp* grasp : grasps) {
    if (grasp->held_on_shapes.empty()) break;
    chances.push_back(chances_of(*grasp));
  }
  if (chances.empty()) return {};
  return decide(chances, grasp::shape_weights(object), jaws, options, probe, look);
}

}  // namespace prehend::planning
