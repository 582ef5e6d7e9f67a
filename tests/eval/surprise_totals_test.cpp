#include "eval/grasp/surprise_totals.h"

#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/grasp/grasp_report.h"

namespace prehend::eval {
namespace {

using control::Surprise;
using control::SurpriseKind;
using ::testing::HasSubstr;

Surprise felt(SurpriseKind kind, double predicted, double value, bool surprising) {
  return {kind, predicted, value, 0, surprising, ""};
}

GraspCase felt_case(const std::string& platform, double robustness,
                    std::vector<Surprise> surprises) {
  GraspCase one;
  one.group = "household";
  one.data_set = "can";
  one.platform = platform;
  for (const char* setting : {"predicted", "truth"}) {
    GraspTrial trial;
    trial.setting = setting;
    trial.grasps = trial.attempts = 1;
    trial.best_robustness = robustness;
    trial.stage = "lift";
    trial.outcome = "lost it";
    one.trials.push_back(trial);
  }
  one.trials[0].surprises = std::move(surprises);
  return one;
}

TEST(SurpriseTotals, AreCountedByHandAndKindOfObjectsThatFit) {
  const std::vector<GraspCase> cases{
      felt_case("a", 0.9,
                {felt(SurpriseKind::kTactileSum, 8, 5, true),
                 felt(SurpriseKind::kTactileSum, 8, 8.5, false),
                 felt(SurpriseKind::kHeldAfterLift, 1, 1, false)}),
      felt_case("a", 0.9, {felt(SurpriseKind::kTactileSum, 8, 7, false)}),
      felt_case("a", 0.1, {felt(SurpriseKind::kTactileSum, 8, 0, true)}),  // does not fit
      felt_case("b", 0.9, {felt(SurpriseKind::kTactileSum, 8, 2, true)})};
  const auto totals = surprise_totals(cases);
  ASSERT_EQ(totals.size(), 3u);
  EXPECT_EQ(totals[0].platform, "a");
  EXPECT_EQ(totals[0].setting, "predicted");
  EXPECT_EQ(totals[0].kind, SurpriseKind::kTactileSum);
  EXPECT_EQ(totals[0].attempts, 2);
  EXPECT_EQ(totals[0].compared, 3);
  EXPECT_EQ(totals[0].surprising, 1);
  EXPECT_EQ(totals[0].difference, -1);
  EXPECT_EQ(totals[1].kind, SurpriseKind::kHeldAfterLift);
  EXPECT_EQ(totals[1].surprising, 0);
  EXPECT_EQ(totals[2].platform, "b");
  EXPECT_EQ(totals[2].surprising, 1);
  const std::string text = grasp_text(cases);
  EXPECT_THAT(text, HasSubstr("tactile sum"));
  EXPECT_THAT(text, HasSubstr("1 (50 % of attempts)"));
  EXPECT_THAT(text, HasSubstr("lift"));
  EXPECT_THAT(grasp_json(cases), HasSubstr("\"felt_less_predicted\""));
}

TEST(SurpriseTotals, KindsHaveNamesOfTheirOwnAndNothingIsFeltOfNothing) {
  std::set<std::string> names;
  for (int kind = 0; kind <= static_cast<int>(SurpriseKind::kSlip); ++kind) {
    names.insert(to_string(static_cast<SurpriseKind>(kind)));
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(SurpriseKind::kSlip) + 1);
  EXPECT_FALSE(names.contains("unknown"));
  EXPECT_TRUE(surprise_totals({}).empty());
  const double nan = std::nan("");
  const auto partly = surprise_totals({felt_case(
      "a", 0.9,
      {felt(SurpriseKind::kTactileSum, 8, nan, true), felt(SurpriseKind::kTactileSum, 8, 9, false),
       felt(SurpriseKind::kContactArea, nan, nan, true)})});
  ASSERT_EQ(partly.size(), 2u);
  EXPECT_TRUE(std::isnan(partly[0].difference)) << "the area, of which nothing is known";
  EXPECT_EQ(partly[1].difference, 1);
  EXPECT_TRUE(surprises_rows({felt_case("a", 0.9, {})}).empty());
}

}  // namespace
}  // namespace prehend::eval
