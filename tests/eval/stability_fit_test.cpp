#include "eval/grasp/stability_fit.h"

#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::eval {
namespace {

TEST(RocArea, IsTheShareOfPairsInOrder) {
  // Of the pairs (held, lost): 0.9 > 0.4, 0.9 > 0.8, 0.6 > 0.4, not 0.6 > 0.8.
  EXPECT_DOUBLE_EQ(roc_area({{0.9, true}, {0.8, false}, {0.6, true}, {0.4, false}}), 0.75);
  EXPECT_DOUBLE_EQ(roc_area({{0.5, true}, {0.5, false}}), 0.5) << "a tie is half";
  EXPECT_DOUBLE_EQ(roc_area({{1, true}, {0, false}}), 1);
  EXPECT_TRUE(std::isnan(roc_area({{1, true}, {0, true}}))) << "nothing to tell apart";
  EXPECT_TRUE(std::isnan(roc_area({})));
}

TEST(RocCurve, GoesFromNoneToAllAndNeverBack) {
  const auto curve = roc_curve({{0.9, true}, {0.8, false}, {0.8, true}, {0.1, false}});
  EXPECT_EQ(curve.front(), (std::pair<double, double>(0, 0)));
  EXPECT_EQ(curve.back(), (std::pair<double, double>(1, 1)));
  for (std::size_t i = 1; i < curve.size(); ++i) {
    EXPECT_GE(curve[i].first, curve[i - 1].first);
    EXPECT_GE(curve[i].second, curve[i - 1].second);
  }
}

/// Grasps of `objects` objects, 20 each; the first feature decides, logistically, the second says
/// nothing, the third is the object's own number.
std::vector<KnownHold> drawn(int objects, double slope, double bias) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<KnownHold> known;
  for (int object = 0; object < objects; ++object) {
    for (int i = 0; i < 20; ++i) {
      Eigen::VectorXd x(3);
      x << normal(random), normal(random), object;
      const bool held = unit(random) < 1 / (1 + std::exp(-(slope * x[0] + bias)));
      known.push_back({x, held, "object " + std::to_string(object), i % 2 ? "a" : "b"});
    }
  }
  return known;
}

TEST(FitStability, FindsTheLogisticThatMadeTheAnswers) {
  const auto model = fit_stability(drawn(200, 2, -1), 1e-3);
  EXPECT_NEAR(model.weight[0] / model.deviation[0], 2, 0.15);
  EXPECT_NEAR(model.weight[1] / model.deviation[1], 0, 0.15);
  EXPECT_NEAR(model.bias - model.weight[0] * model.mean[0] / model.deviation[0], -1, 0.15);
}

TEST(FitStability, IsTheSameTwice) {
  const auto known = drawn(10, 2, 0);
  EXPECT_EQ(fit_stability(known).weight, fit_stability(known).weight);
}

TEST(FitStability, NeedsBothAnswers) {
  auto known = drawn(5, 2, 0);
  for (KnownHold& one : known) one.held = true;
  EXPECT_THROW(fit_stability(known), std::invalid_argument);
  EXPECT_THROW(fit_stability({}), std::invalid_argument);
}

// Were an object's own grasps learned from, its number would tell its answer.
TEST(CrossedProbabilities, KnowNothingOfTheObjectThatIsAskedAbout) {
  std::mt19937 random(6);
  std::vector<KnownHold> known;
  for (int object = 0; object < 60; ++object) {
    const bool held = random() % 2 == 0;
    for (int i = 0; i < 10; ++i) {
      Eigen::VectorXd x = Eigen::VectorXd::Zero(60);
      x[object] = 1;
      known.push_back({x, held, "object " + std::to_string(object), "a"});
    }
  }
  std::vector<Answer> answers;
  const auto said = crossed_probabilities(known, 10);
  for (std::size_t i = 0; i < known.size(); ++i) answers.emplace_back(said[i], known[i].held);
  EXPECT_LT(roc_area(answers), 0.6);
}

TEST(CrossedProbabilities, TellWhatTheFeatureTells) {
  const auto known = drawn(30, 6, 0);
  for (const bool per_hand : {false, true}) {
    const auto said = crossed_probabilities(known, 10, per_hand);
    std::vector<Answer> answers;
    std::vector<std::string> objects;
    for (std::size_t i = 0; i < known.size(); ++i) {
      answers.emplace_back(said[i], known[i].held);
      objects.push_back(known[i].object);
    }
    const double area = roc_area(answers);
    EXPECT_GT(area, 0.93);
    const AreaBounds bounds = area_bounds(answers, objects);
    EXPECT_LT(bounds.low, area);
    EXPECT_GT(bounds.high, area);
    EXPECT_LT(bounds.high - bounds.low, 0.1);
  }
}

}  // namespace
}  // namespace prehend::eval
