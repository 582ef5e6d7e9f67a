#include "eval/confidence_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <set>
#include <stdexcept>

#include <Eigen/Dense>

namespace prehend::eval {
namespace {

using shape::ConfidenceModel;
using shape::Evidence;

constexpr int kMethods = 5;
constexpr int kCoefficients = 18;
constexpr int kMostSteps = 5000;
constexpr double kLeastStep = 0.1;  // between methods: fall-backs stay in their order

// In the order of shape::CompletionMethod, then the others; features() has the same order.
constexpr std::array<std::pair<const char*, double ConfidenceModel::*>, kCoefficients> kNames = {
    {{"mirror", &ConfidenceModel::mirror},
     {"rotation", &ConfidenceModel::rotation},
     {"extrusion", &ConfidenceModel::extrusion},
     {"convex_hull", &ConfidenceModel::convex_hull},
     {"refused_mirror", &ConfidenceModel::refused_mirror},
     {"contradiction", &ConfidenceModel::contradiction},
     {"contradicted", &ConfidenceModel::contradicted},
     {"unsupported", &ConfidenceModel::unsupported},
     {"unseen", &ConfidenceModel::unseen},
     {"ambiguous", &ConfidenceModel::ambiguous},
     {"concavity", &ConfidenceModel::concavity},
     {"open_vessel", &ConfidenceModel::open_vessel},
     {"cut_by_image", &ConfidenceModel::cut_by_image},
     {"occluded", &ConfidenceModel::occluded},
     {"on_another", &ConfidenceModel::on_another},
     {"disagreement", &ConfidenceModel::disagreement},
     {"guessed_depth", &ConfidenceModel::guessed_depth},
     {"may_be_several", &ConfidenceModel::may_be_several}}};

using Vector = Eigen::Matrix<double, kCoefficients, 1>;

// The log-odds are features . coefficients. They are found by asking confidence() itself, so that
// the two cannot differ: it is linear in the coefficients.
Vector features(const Evidence& evidence) {
  ConfidenceModel none;
  for (const auto& [name, value] : kNames) none.*value = 0;
  Vector result;
  for (int k = 0; k < kCoefficients; ++k) {
    ConfidenceModel one = none;
    one.*kNames[k].second = 1;
    const double p = shape::confidence(evidence, one);
    result[k] = std::log(p / (1 - p));
  }
  return result;
}

Vector coefficients(const ConfidenceModel& model) {
  Vector result;
  for (int k = 0; k < kCoefficients; ++k) result[k] = model.*kNames[k].second;
  return result;
}

}  // namespace

ConfidenceModel fitted_confidence(const std::vector<JudgedEvidence>& judged,
                                  const ConfidenceModel& start, double prior_width) {
  if (judged.empty()) throw std::invalid_argument("fitted_confidence: nothing was judged");
  std::vector<Vector> rows;
  for (const JudgedEvidence& one : judged) rows.push_back(features(one.evidence));
  const Vector prior = coefficients(start);
  const double stiffness = 1 / (prior_width * prior_width);
  // A bound of the curvature gives a step that always descends.
  Eigen::Matrix<double, kCoefficients, kCoefficients> curvature =
      stiffness * Eigen::Matrix<double, kCoefficients, kCoefficients>::Identity();
  for (const Vector& row : rows) curvature += 0.25 * row * row.transpose();
  const double step =
      1 /
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kCoefficients, kCoefficients>>(curvature)
          .eigenvalues()
          .maxCoeff();
  Vector w = prior;
  for (int i = 0; i < kMostSteps; ++i) {
    Vector gradient = stiffness * (w - prior);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const double p = 1 / (1 + std::exp(-rows[k].dot(w)));
      gradient += (p - (judged[k].right ? 1.0 : 0.0)) * rows[k];
    }
    Vector next = w - step * gradient;
    next.tail<kCoefficients - kMethods>() = next.tail<kCoefficients - kMethods>().cwiseMax(0);
    for (int k = 1; k < kMethods; ++k) next[k] = std::min(next[k], next[k - 1] - kLeastStep);
    const double change = (next - w).norm();
    w = next;
    if (change < 1e-7) break;
  }
  ConfidenceModel model;
  // Two digits after the point are more than the data can tell.
  for (int k = 0; k < kCoefficients; ++k) {
    model.*kNames[k].second = std::round(100 * w[k]) / 100;
  }
  return model;
}

std::string to_yaml(const ConfidenceModel& model) {
  std::string text;
  for (const auto& [name, value] : kNames) text += fmt::format("{}: {:.2f}\n", name, model.*value);
  return text;
}

std::vector<double> cross_validated(const std::vector<JudgedEvidence>& judged,
                                    const ConfidenceModel& start, double prior_width) {
  std::vector<double> confidences(judged.size());
  std::set<std::string> objects;
  for (const JudgedEvidence& one : judged) objects.insert(one.object);
  for (const std::string& object : objects) {
    std::vector<JudgedEvidence> others;
    std::copy_if(judged.begin(), judged.end(), std::back_inserter(others),
                 [&](const JudgedEvidence& one) { return one.object != object; });
    const ConfidenceModel model =
        others.empty() ? start : fitted_confidence(others, start, prior_width);
    for (std::size_t i = 0; i < judged.size(); ++i) {
      if (judged[i].object == object) {
        confidences[i] = shape::confidence(judged[i].evidence, model);
      }
    }
  }
  return confidences;
}

Calibration calibration_of(const std::vector<JudgedEvidence>& judged,
                           const std::vector<double>& confidences, double least) {
  Calibration result;
  for (std::size_t i = 0; i < judged.size(); ++i) {
    result.all_right += judged[i].right;
    if (confidences[i] < least) continue;
    ++result.sure;
    result.right += judged[i].right;
  }
  return result;
}

Calibration calibration_of(const std::vector<JudgedEvidence>& judged, const ConfidenceModel& model,
                           double least) {
  std::vector<double> confidences;
  for (const JudgedEvidence& one : judged) {
    confidences.push_back(shape::confidence(one.evidence, model));
  }
  return calibration_of(judged, confidences, least);
}

}  // namespace prehend::eval
