#include "eval/deviation_summary.h"

#include <cmath>

#include <gtest/gtest.h>

namespace prehend::eval {
namespace {

CaseResult made(const std::string& data_set, int orientation, double ours, double mir7) {
  CaseResult result;
  result.group = "some";
  result.data_set = data_set;
  result.orientation = orientation;
  result.methods.resize(2);
  result.methods[0].method = "Ours";
  result.methods[0].mean = ours;
  result.methods[0].watertight = true;
  result.methods[1].method = "Mir7";
  result.methods[1].mean = mir7;
  return result;
}

Goal goal_named(const std::vector<Goal>& goals, const std::string& part) {
  for (const Goal& goal : goals) {
    if (goal.name.find(part) != std::string::npos) return goal;
  }
  ADD_FAILURE() << "no goal '" << part << "'";
  return {};
}

TEST(DeviationSummary, MeansAndSpreadsByRow) {
  const std::vector<CaseResult> results = {made("a", 0, 0.001, 0.004), made("a", 45, 0.003, 0.004),
                                           made("b", 0, kUnknown, 0.006)};
  const SummaryTable table = summarize(
      results, [](const CaseResult& r) { return r.data_set; },
      [](const MethodResult& m) { return m.mean; });
  ASSERT_EQ(table.rows, (std::vector<std::string>{"a", "b"}));
  ASSERT_EQ(table.methods, (std::vector<std::string>{"Ours", "Mir7"}));
  EXPECT_DOUBLE_EQ(table.cells[0][0].mean, 0.002);
  EXPECT_DOUBLE_EQ(table.cells[0][0].deviation, 0.001);
  EXPECT_EQ(table.cells[1][0].count, 0);
  EXPECT_TRUE(std::isnan(table.cells[1][0].mean));
  EXPECT_EQ(to_csv(table, "object", 1000),
            "object,Ours mean,Ours deviation,Ours count,Mir7 mean,Mir7 deviation,Mir7 count\n"
            "a,2.0000,1.0000,2,4.0000,0.0000,2\n"
            "b,,,0,6.0000,0.0000,1\n");
}

TEST(DeviationSummary, GoalsPassAndMiss) {
  std::vector<CaseResult> results = {made("a", 0, 0.001, 0.004), made("b", 0, 0.0047, 0.004)};
  std::vector<Goal> goals = judge(results);
  EXPECT_EQ(goal_named(goals, "Ours, mean deviation").outcome, Goal::Outcome::kMet);
  const Goal worse = goal_named(goals, "Ours against Mir7");
  EXPECT_EQ(worse.outcome, Goal::Outcome::kMissed);
  EXPECT_EQ(worse.measured, "+0.70 mm on b");
  EXPECT_EQ(goal_named(goals, "against Del").outcome, Goal::Outcome::kNotMeasured);
  EXPECT_EQ(goal_named(goals, "fall-back").outcome, Goal::Outcome::kNotMeasured);
  EXPECT_EQ(goal_named(goals, "watertight").outcome, Goal::Outcome::kMet);

  // A method without a result on a whole data set misses, however good the others are.
  results[1] = made("b", 0, kUnknown, 0.004);
  results[1].methods[0].watertight = false;
  goals = judge(results);
  EXPECT_EQ(goal_named(goals, "Ours against Mir7").measured, "no result on b");
  EXPECT_EQ(goal_named(goals, "watertight").outcome, Goal::Outcome::kMissed);
}

TEST(DeviationSummary, CalibrationCountsOnlySureResults) {
  std::vector<CaseResult> results;
  for (int i = 0; i < 10; ++i) {
    results.push_back(made("a", i, i < 8 ? 0.002 : 0.009, 0.004));
    results.back().methods[0].back_mean = 0.002;
    results.back().methods[0].confidence = 0.95;
  }
  EXPECT_EQ(goal_named(judge(results), "sure").outcome, Goal::Outcome::kMissed);  // 80 %
  results[9].methods[0].confidence = 0.5;
  EXPECT_EQ(goal_named(judge(results), "sure").outcome, Goal::Outcome::kMet);  // 8 of 9
  // What was merged with another covers the truth, and is not it.
  results[0].methods[0].back_mean = 0.03;
  EXPECT_EQ(goal_named(judge(results), "sure").outcome, Goal::Outcome::kMissed);
}

}  // namespace
}  // namespace prehend::eval
