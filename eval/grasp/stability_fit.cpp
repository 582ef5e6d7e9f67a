#include "eval/grasp/stability_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <stdexcept>

#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>

#include "eval/case_result.h"

namespace prehend::eval {
namespace {

using touch::GraspStability;

constexpr double kLeastDeviation = 1e-9;  // of a feature that tells something
constexpr int kResamples = 1000;

// Negative log likelihood of the answers, over bias and weights.
class Unlikelihood : public ceres::FirstOrderFunction {
 public:
  Unlikelihood(Eigen::MatrixXd units, Eigen::VectorXd held, double ridge)
      : units_(std::move(units)), held_(std::move(held)), ridge_(ridge) {}

  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    const auto size = units_.cols();
    const Eigen::Map<const Eigen::VectorXd> weight(parameters + 1, size);
    const Eigen::ArrayXd score = (units_ * weight).array() + parameters[0];
    // log(1 + e^s) without overflow.
    *cost = (score.max(0) + (1 + (-score.abs()).exp()).log() - held_.array() * score).sum() +
            ridge_ / 2 * weight.squaredNorm();
    if (gradient == nullptr) return true;
    const Eigen::VectorXd off = (1 / (1 + (-score).exp()) - held_.array()).matrix();
    gradient[0] = off.sum();
    Eigen::Map<Eigen::VectorXd>(gradient + 1, size) = units_.transpose() * off + ridge_ * weight;
    return true;
  }
  int NumParameters() const override { return static_cast<int>(units_.cols()) + 1; }

 private:
  Eigen::MatrixXd units_;
  Eigen::VectorXd held_;
  double ridge_;
};

bool answers_differ(const std::vector<KnownHold>& known) {
  return std::any_of(known.begin(), known.end(), [](const auto& one) { return one.held; }) &&
         std::any_of(known.begin(), known.end(), [](const auto& one) { return !one.held; });
}

double probability(const GraspStability::Weighed& model, const Eigen::VectorXd& features) {
  const Eigen::ArrayXd units = (features - model.mean).array() / model.deviation.array();
  return 1 / (1 + std::exp(-(model.bias + units.matrix().dot(model.weight))));
}

}  // namespace

GraspStability::Weighed fit_stability(const std::vector<KnownHold>& known, double ridge) {
  if (!answers_differ(known)) {
    throw std::invalid_argument("fit_stability: needs grasps that held and others that did not");
  }
  const auto count = static_cast<Eigen::Index>(known.size());
  const Eigen::Index size = known.front().features.size();
  Eigen::MatrixXd units(count, size);
  Eigen::VectorXd held(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const KnownHold& one = known[static_cast<std::size_t>(i)];
    units.row(i) = one.features.transpose();
    held[i] = one.held ? 1 : 0;
  }
  GraspStability::Weighed model;
  model.mean = units.colwise().mean().transpose();
  units.rowwise() -= model.mean.transpose();
  model.deviation = (units.colwise().squaredNorm() / static_cast<double>(count)).cwiseSqrt();
  for (double& deviation : model.deviation) {
    if (deviation < kLeastDeviation) deviation = 1;
  }
  units.array().rowwise() /= model.deviation.transpose().array();
  std::vector<double> parameters(static_cast<std::size_t>(size) + 1, 0.0);
  const ceres::GradientProblem problem(new Unlikelihood(units, held, ridge));
  ceres::GradientProblemSolver::Options options;
  options.max_num_iterations = 500;
  options.logging_type = ceres::SILENT;
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(options, problem, parameters.data(), &summary);
  model.bias = parameters[0];
  model.weight = Eigen::Map<const Eigen::VectorXd>(parameters.data() + 1, size);
  return model;
}

std::vector<double> crossed_probabilities(const std::vector<KnownHold>& known, int folds,
                                          bool per_hand) {
  std::map<std::string, int> fold;
  for (const KnownHold& one : known) fold.emplace(one.object, 0);
  int next = 0;
  for (auto& [object, of] : fold) of = next++ % folds;
  std::set<std::string> hands;
  for (const KnownHold& one : known) hands.insert(per_hand ? one.hand : "");
  std::vector<double> probabilities(known.size(), kUnknown);
  for (int k = 0; k < folds; ++k) {
    for (const std::string& hand : hands) {
      const auto is_meant = [&](const KnownHold& one) { return !per_hand || one.hand == hand; };
      std::vector<KnownHold> others;
      for (const KnownHold& one : known) {
        if (is_meant(one) && fold.at(one.object) != k) others.push_back(one);
      }
      if (others.empty() || !answers_differ(others)) continue;
      const GraspStability::Weighed model = fit_stability(others);
      for (std::size_t i = 0; i < known.size(); ++i) {
        if (!is_meant(known[i]) || fold.at(known[i].object) != k) continue;
        probabilities[i] = probability(model, known[i].features);
      }
    }
  }
  return probabilities;
}

std::vector<std::pair<double, double>> roc_curve(std::vector<Answer> answers) {
  std::sort(answers.begin(), answers.end(),
            [](const Answer& a, const Answer& b) { return a.first > b.first; });
  double held = 0, lost = 0;
  for (const Answer& answer : answers) (answer.second ? held : lost) += 1;
  std::vector<std::pair<double, double>> curve{{0, 0}};
  double above_held = 0, above_lost = 0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    (answers[i].second ? above_held : above_lost) += 1;
    const bool tied = i + 1 < answers.size() && answers[i + 1].first == answers[i].first;
    if (!tied) curve.emplace_back(above_lost / lost, above_held / held);
  }
  return curve;
}

double roc_area(const std::vector<Answer>& answers) {
  const std::vector<std::pair<double, double>> curve = roc_curve(answers);
  double area = 0;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    area += (curve[i].first - curve[i - 1].first) * (curve[i].second + curve[i - 1].second) / 2;
  }
  return answers.empty() ? kUnknown : area;
}

AreaBounds area_bounds(const std::vector<Answer>& answers,
                       const std::vector<std::string>& objects) {
  std::map<std::string, std::vector<Answer>> of;
  for (std::size_t i = 0; i < answers.size(); ++i) of[objects.at(i)].push_back(answers[i]);
  std::vector<const std::vector<Answer>*> all;
  for (const auto& [object, own] : of) all.push_back(&own);
  std::mt19937 random(1);
  std::vector<double> areas;
  for (int k = 0; k < kResamples && !all.empty(); ++k) {
    std::vector<Answer> drawn;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const std::vector<Answer>& own = *all[random() % all.size()];
      drawn.insert(drawn.end(), own.begin(), own.end());
    }
    const double area = roc_area(drawn);
    if (std::isfinite(area)) areas.push_back(area);
  }
  if (areas.empty()) return {kUnknown, kUnknown};
  std::sort(areas.begin(), areas.end());
  const auto at = [&](double share) {
    return areas[static_cast<std::size_t>(share * static_cast<double>(areas.size() - 1))];
  };
  return {at(0.025), at(0.975)};
}

}  // namespace prehend::eval
