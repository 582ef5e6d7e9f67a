// What is worth most: to grasp, to feel first, to look, or to leave it.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/planning/decision.h"

namespace prehend::planning {
namespace {

using ::testing::HasSubstr;

// A grasp that holds surely or not at all.
DecisionOptions sure() {
  DecisionOptions options;
  options.success_of_none = 0;
  options.success_of_all = 1;
  return options;
}

Eigen::VectorXd stop(double at) { return Eigen::VectorXd::Constant(1, at); }

const Choice& of(const std::vector<Choice>& choices, Act act, int grasp = -1) {
  const auto found = std::find_if(choices.begin(), choices.end(), [&](const Choice& one) {
    return one.act == act && (grasp < 0 || one.grasp == grasp);
  });
  if (found == choices.end()) throw std::out_of_range(to_string(act));
  return *found;
}

// Two shapes, a grasp for each; where the hand stops tells them apart by so many deviations.
std::vector<GraspChances> grasp_for_each(double apart) {
  const double step = apart * DecisionOptions().stop_deviation_length;
  return {{{1, 0}, {stop(0.02), stop(0.02 + step)}}, {{0, 1}, {stop(0.02), stop(0.02 + step)}}};
}

TEST(Decide, OneAttemptIsWorthWhatItsChanceIs) {
  DecisionOptions options;
  options.attempts = 1;
  const std::vector<Choice> choices = decide({{{0.5}, {}}}, {1}, true, options);
  const double success = (options.success_of_none + options.success_of_all) / 2;
  EXPECT_EQ(choices.front().act, Act::kGrasp);
  EXPECT_NEAR(choices.front().success, success, 1e-12);
  EXPECT_NEAR(choices.front().worth,
              success * options.value - options.attempt - (1 - success) * options.failure, 1e-9);
}

TEST(Decide, AFailureTellsTheShapeAndTheOtherGraspIsNext) {
  DecisionOptions options = sure();
  const Choice now = of(decide(grasp_for_each(0), {0.5, 0.5}, true, options), Act::kGrasp);
  const double after = options.value - options.attempt;
  EXPECT_NEAR(now.worth, 0.5 * after + 0.5 * (-options.attempt - options.failure + after), 1e-9);
  options.attempts = 1;
  const Choice last = of(decide(grasp_for_each(0), {0.5, 0.5}, true, options), Act::kGrasp);
  EXPECT_NEAR(last.worth, 0.5 * after + 0.5 * (-options.attempt - options.failure), 1e-9);
}

TEST(Decide, ItIsFeltFirstExactlyWhereThatCostsLessThanItSaves) {
  DecisionOptions options = sure();
  const double saved = 0.5 * (options.attempt + options.failure);
  for (const double cost : {saved - 0.1, saved + 0.1}) {
    options.touch = cost;
    const std::vector<Choice> choices = decide(grasp_for_each(100), {0.5, 0.5}, true, options);
    EXPECT_NEAR(of(choices, Act::kTouch, 0).worth, options.value - options.attempt - cost, 1e-6);
    EXPECT_NEAR(of(choices, Act::kTouch, 0).success, 1, 1e-9);
    EXPECT_EQ(choices.front().act, cost < saved ? Act::kTouch : Act::kGrasp);
  }
}

TEST(Decide, WhatTellsNothingIsWorthNothing) {
  const DecisionOptions options = sure();
  const std::vector<Choice> choices = decide(grasp_for_each(0), {0.5, 0.5}, true, options);
  EXPECT_NEAR(of(choices, Act::kTouch, 0).worth, of(choices, Act::kGrasp).worth - options.touch,
              1e-9);
  DecisionOptions none = options;
  none.touches = 0;
  EXPECT_THROW(of(decide(grasp_for_each(9), {0.5, 0.5}, true, none), Act::kTouch),
               std::out_of_range);
}

TEST(Decide, AProbeIsMadeExactlyWhereItCostsLessThanItSaves) {
  DecisionOptions options = sure();
  const double saved = 0.5 * (options.attempt + options.failure);
  for (const double cost : {saved - 0.1, saved + 0.1}) {
    options.touch = cost;
    const std::vector<Choice> choices =
        decide(grasp_for_each(0), {0.5, 0.5}, true, options, {0.02, 0.08});
    EXPECT_NEAR(of(choices, Act::kProbe).worth, options.value - options.attempt - cost, 1e-6);
    EXPECT_EQ(choices.front().act, cost < saved ? Act::kProbe : Act::kGrasp);
  }
  // Where all shapes stop it alike, it tells nothing.
  const std::vector<Choice> alike =
      decide(grasp_for_each(0), {0.5, 0.5}, true, options, {0.05, 0.05});
  EXPECT_NEAR(of(alike, Act::kProbe).worth, of(alike, Act::kGrasp).worth - options.touch, 1e-9);
  EXPECT_THROW(decide(grasp_for_each(0), {0.5, 0.5}, true, options, {0.05}), std::invalid_argument);
  EXPECT_THROW(decide(grasp_for_each(0), {0.5, 0.5}, true, options, {0.05, std::nan("")}),
               std::invalid_argument);
}

// Against drawing where the hand stops, for shapes that are hard and easy to tell apart.
TEST(Decide, TouchesAreWorthWhatDrawingSays) {
  const DecisionOptions options = sure();
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (const double apart : {0.5, 1.0, 2.0, 4.0}) {
    double success = 0;
    constexpr int kDraws = 20000;
    for (int i = 0; i < kDraws; ++i) {
      const bool second = i % 2 == 1;
      const double felt = normal(random) + (second ? apart : 0);
      const double first = std::exp(-0.5 * felt * felt);
      const double other = std::exp(-0.5 * (felt - apart) * (felt - apart));
      success += std::max(first, other) / (first + other) / kDraws;
    }
    const auto choices = decide(grasp_for_each(apart), {0.5, 0.5}, true, options);
    EXPECT_NEAR(of(choices, Act::kTouch, 0).success, success, 0.05) << apart;
  }
}

TEST(Decide, ToKnowMoreNeverHurts) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform;
  DecisionOptions options;
  for (int trial = 0; trial < 300; ++trial) {
    const std::size_t shapes = 2 + trial % 3;
    std::vector<double> weights;
    double sum = 0;
    for (std::size_t k = 0; k < shapes; ++k) sum += weights.emplace_back(uniform(random));
    for (double& weight : weights) weight /= sum;
    std::vector<GraspChances> grasps(3);
    for (GraspChances& grasp : grasps) {
      for (std::size_t k = 0; k < shapes; ++k) {
        grasp.held.push_back(uniform(random));
        grasp.stops.push_back(stop(0.01 * uniform(random)));
      }
    }
    const auto choices = decide(grasps, weights, true, options);
    const double now = of(choices, Act::kGrasp).worth;
    for (int g = 0; g < 3; ++g) {
      EXPECT_GE(of(choices, Act::kTouch, g).worth + options.touch, now - 0.02 * options.value);
      EXPECT_GE(of(choices, Act::kLook).worth,
                of(choices, Act::kTouch, g).worth + options.touch - 0.02 * options.value);
    }
  }
}

TEST(Decide, WhatCannotBeHeldIsLeftAndSaidWhy) {
  const auto choices = decide({{{0, 0}, {}}}, {0.5, 0.5}, false, sure());
  EXPECT_EQ(choices.front().act, Act::kGiveUp);
  EXPECT_THAT(choices.front().text, HasSubstr("leave it: grasp it now: lifted with 0.00"));
  EXPECT_EQ(decide({}, {1}, false, sure()).front().act, Act::kGiveUp);
}

LookChances look_that_shows(double apart) {
  LookChances look;
  look.apart.setZero(2, 2);
  look.apart(0, 1) = look.apart(1, 0) = apart;
  look.from = "the left";
  return look;
}

TEST(Decide, ALookIsMadeExactlyWhereItCostsLessThanItSaves) {
  DecisionOptions options = sure();
  const double saved = 0.5 * (options.attempt + options.failure);
  for (const double cost : {saved - 0.1, saved + 0.1}) {
    options.look = cost;
    const auto choices =
        decide(grasp_for_each(0), {0.5, 0.5}, true, options, {}, look_that_shows(0.03));
    EXPECT_NEAR(of(choices, Act::kLook).worth, options.value - options.attempt - cost, 1e-6);
    EXPECT_THAT(of(choices, Act::kLook).text, HasSubstr("look at it from the left first"));
    EXPECT_EQ(choices.front().act, cost < saved ? Act::kLook : Act::kGrasp);
  }
  // What it cannot tell apart it is worth nothing for; and by as much as it can, like a touch.
  options = sure();
  const auto alike = decide(grasp_for_each(0), {0.5, 0.5}, true, options, {}, look_that_shows(0));
  EXPECT_NEAR(of(alike, Act::kLook).worth, of(alike, Act::kGrasp).worth - options.look, 1e-9);
  for (const double deviations : {0.5, 1.0, 2.0}) {
    const auto looked = decide(grasp_for_each(0), {0.5, 0.5}, true, options, {},
                               look_that_shows(deviations * options.look_deviation));
    const auto probed = decide(grasp_for_each(0), {0.5, 0.5}, true, options,
                               {0.05, 0.05 + deviations * options.stop_deviation_probe});
    EXPECT_NEAR(of(looked, Act::kLook).success, of(probed, Act::kProbe).success, 1e-9);
  }
}

TEST(Decide, ALookThatNobodyCanTakeIsToldAndNotChosen) {
  DecisionOptions options = sure();
  auto choices = decide(grasp_for_each(0), {0.5, 0.5}, true, options);
  EXPECT_EQ(choices.back().act, Act::kLook);
  EXPECT_NEAR(choices.back().success, 1, 1e-12);
  EXPECT_THAT(choices.back().text, HasSubstr("no camera can get there"));
  LookChances blocked;
  blocked.problem = "the arm cannot bring the camera there";
  choices = decide(grasp_for_each(0), {0.5, 0.5}, true, options, {}, blocked);
  EXPECT_THAT(choices.back().text, HasSubstr("the arm cannot bring the camera there"));
  options.looks = 0;
  choices = decide(grasp_for_each(0), {0.5, 0.5}, true, options, {}, look_that_shows(0.03));
  EXPECT_EQ(choices.back().act, Act::kLook) << "it is the last";
  LookChances other = look_that_shows(0.01);
  other.apart.setZero(3, 3);
  EXPECT_THROW(decide(grasp_for_each(0), {0.5, 0.5}, true, options, {}, other),
               std::invalid_argument);
  other = look_that_shows(std::nan(""));
  EXPECT_THROW(decide(grasp_for_each(0), {0.5, 0.5}, true, options, {}, other),
               std::invalid_argument);
}

// Jaws that close on air on one of the shapes are told from those that stop.
TEST(Decide, ClosingOnAirTells) {
  std::vector<GraspChances> grasps = grasp_for_each(0);
  for (GraspChances& grasp : grasps) grasp.stops[1] = {};
  const auto choices = decide(grasps, {0.5, 0.5}, true, sure());
  EXPECT_NEAR(of(choices, Act::kTouch, 1).success, 1, 1e-9);
}

TEST(Decide, AShapeWithoutATrialCountsAsTheOthersDo) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto choices = decide({{{1, nan}, {}}}, {0.5, 0.5}, true, sure());
  EXPECT_NEAR(of(choices, Act::kGrasp).success, 1, 1e-12);
}

TEST(Decide, NonsenseIsRefusedByName) {
  const std::vector<GraspChances> grasps = grasp_for_each(1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(decide(grasps, {1}, true, {}), std::invalid_argument);
  EXPECT_THROW(decide(grasps, {0.5, 0.6}, true, {}), std::invalid_argument);
  EXPECT_THROW(decide(grasps, {nan, 1}, true, {}), std::invalid_argument);
  EXPECT_THROW(decide(grasps, {-0.5, 1.5}, true, {}), std::invalid_argument);
  EXPECT_THROW(decide({{{1.5, 0}, {}}}, {0.5, 0.5}, true, {}), std::invalid_argument);
  EXPECT_THROW(decide({{{1, 0}, {stop(0)}}}, {0.5, 0.5}, true, {}), std::invalid_argument);
  DecisionOptions options;
  options.success_of_all = 0.1;
  try {
    decide(grasps, {0.5, 0.5}, true, options);
    FAIL() << "success_of_all below success_of_none was taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("DecisionOptions.success_of_all"));
  }
}

}  // namespace
}  // namespace prehend::planning
