// The ends of each axis of docs/chain_extremes.md, and what counts as what there.

#include "eval/grasp/chain_extremes.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

const char* const kPlatform = "config/robots/stage_pg70.yaml";

ExtremeCase with(double ExtremeCase::*value, double extreme) {
  ExtremeCase one;
  one.*value = extreme;
  return one;
}

ExtremeResult with_mesh(double error, double confidence, bool planned, bool lifted) {
  ExtremeResult result;
  result.mesh_error = error;
  result.confidence = confidence;
  result.planned = planned;
  result.lifted = lifted;
  return result;
}

// All of the coarse map: nothing throws but what says why, no refusal is without its reason,
// nothing is wrong in silence.
class CoarseExtremes : public ::testing::TestWithParam<ExtremeCase> {};

TEST_P(CoarseExtremes, WorkOrSayWhyNot) {
  static const PlatformUnderTest platform(kPlatform);
  const ExtremeResult result = run_extreme_case(GetParam(), platform);
  EXPECT_NE(result.outcome, ExtremeOutcome::kSilent) << result.stage << ": " << result.message;
  EXPECT_EQ(result.message.empty(), result.outcome == ExtremeOutcome::kWorks);
  EXPECT_EQ(result.stage.empty(), result.outcome == ExtremeOutcome::kWorks);
  EXPECT_LT(result.memory, 2e9) << "bytes";
}

INSTANTIATE_TEST_SUITE_P(Ends, CoarseExtremes, ::testing::ValuesIn(extreme_grid(true).cases()),
                         [](const auto& one) { return std::to_string(one.index); });

// What no chain can do, and what each must.
TEST(Extremes, EndWherePhysicsAndTheHandSay) {
  const PlatformUnderTest platform(kPlatform);
  const ExtremeResult middle = run_extreme_case({}, platform);
  EXPECT_EQ(middle.outcome, ExtremeOutcome::kWorks) << middle.stage << ": " << middle.message;
  EXPECT_GE(middle.confidence, kConfident);
  // 0.25 m of it is wider than 69 mm, the gripper's opening, which is the reason that is given.
  const ExtremeResult wide = run_extreme_case(with(&ExtremeCase::size, 0.25), platform);
  EXPECT_EQ(wide.outcome, ExtremeOutcome::kRefused) << wide.message;
  EXPECT_NE(wide.message.find("exceeds the gripper's"), std::string::npos) << wide.message;
  // A force of 200 N on each pad carries 2 * 0.05 * 200 N, less than 10 kg weigh, at most.
  ExtremeCase heavy = with(&ExtremeCase::mass, 10);
  heavy.friction = 0.05;
  EXPECT_EQ(run_extreme_case(heavy, platform).outcome, ExtremeOutcome::kSaid);
}

TEST(Extremes, WhatIsWrongIsSilentOnlyWithConfidence) {
  using enum ExtremeOutcome;
  EXPECT_EQ(outcome_of(with_mesh(0.001, 0.95, true, true), 0.1), kWorks);
  EXPECT_EQ(outcome_of(with_mesh(0.001, 0.3, true, true), 0.1), kWorks);
  EXPECT_EQ(outcome_of(with_mesh(0.001, 0.95, true, false), 0.1), kSaid);
  EXPECT_EQ(outcome_of(with_mesh(0.001, 0.95, false, false), 0.1), kRefused);
  EXPECT_EQ(outcome_of(with_mesh(0.006, 0.95, true, true), 0.1), kSilent);
  EXPECT_EQ(outcome_of(with_mesh(0.006, 0.95, false, false), 0.1), kSilent) << "whatever the plan";
  EXPECT_EQ(outcome_of(with_mesh(0.006, 0.85, true, true), 0.1), kSaid);
  EXPECT_EQ(outcome_of(with_mesh(0.006, 0.85, false, false), 0.1), kRefused);
  EXPECT_EQ(outcome_of(ExtremeResult{}, 0.1), kRefused) << "without a mesh";
  ExtremeResult dropped = with_mesh(0.001, 0.95, true, false);
  dropped.stage = kSaidUntruly;
  EXPECT_EQ(outcome_of(dropped, 0.1), kSilent);
}

TEST(Extremes, AMeshIsRightWithinItsSizesShare) {
  EXPECT_DOUBLE_EQ(right_within(0.02), 0.002);
  EXPECT_DOUBLE_EQ(right_within(0.05), 0.005);
  EXPECT_DOUBLE_EQ(right_within(0.1), 0.005);
  EXPECT_DOUBLE_EQ(right_within(1), 0.05);
}

TEST(Extremes, ResultsAreReadAsTheyWereWritten) {
  ExtremeResult result = with_mesh(0.003, 0.875, true, false);
  result.outcome = ExtremeOutcome::kSaid;
  result.stage = "lift";
  result.message = "nothing is held: \"left\" pad";
  const ExtremeResult read = read_extreme_result(to_text(result));
  EXPECT_EQ(read.outcome, result.outcome);
  EXPECT_EQ(read.stage, result.stage);
  EXPECT_EQ(read.message, result.message);
  EXPECT_DOUBLE_EQ(read.mesh_error, result.mesh_error);
  EXPECT_DOUBLE_EQ(read.confidence, result.confidence);
  EXPECT_TRUE(read.planned);
  EXPECT_FALSE(read.lifted);
  EXPECT_THROW(read_extreme_result(""), geometry::InputError);
}

TEST(Extremes, EveryCaseIsRunOnce) {
  const std::vector<ExtremeCase> cases = extreme_grid(false).cases();
  std::set<std::string> names;
  for (const ExtremeCase& one : cases) EXPECT_TRUE(names.insert(one.name()).second) << one.name();
}

// A case of each outcome, and one that crashed.
TEST(Extremes, MapsAndTotalsSayWhatCameOfThem) {
  ExtremeGrid grid;
  grid.objects = {"can"};
  grid.seeds = {1};
  grid.axes = {{"mass", "kg", &ExtremeCase::mass, 1, {1, 2, 3, 4, 5}}};
  const std::vector<ExtremeCase> cases = grid.cases();
  ASSERT_EQ(cases.size(), 5u);
  ExtremeResults results;
  for (int i = 0; i < 4; ++i) {
    ExtremeResult& result = results[cases[static_cast<std::size_t>(i)].name()];
    result.outcome = static_cast<ExtremeOutcome>(i);
    result.confidence = i == 3 ? 0.9 : 0.5;
    result.message = i == 1 ? "" : "why";
  }
  const ExtremeTotals sum = totals(cases, results);
  EXPECT_EQ(sum.cases, 5);
  EXPECT_EQ(sum.works, 1);
  EXPECT_EQ(sum.refused, 1);
  EXPECT_EQ(sum.said, 1);
  EXPECT_EQ(sum.silent, 1);
  EXPECT_EQ(sum.crashed, 1);
  EXPECT_EQ(sum.sure, 1);
  EXPECT_EQ(sum.without_a_reason, 1);
  EXPECT_DOUBLE_EQ(sum.silent_share(), 0.2);
  const std::string picture = extremes_picture(grid, results);
  for (const char* text :
       {">1 of 1<", ">refused<", ">said<", ">1 silent<", ">crash<", "mass [kg]"}) {
    EXPECT_NE(picture.find(text), std::string::npos) << text;
  }
  const std::string page = extremes_page(grid, results, "eval", "picture.svg");
  EXPECT_NE(page.find("5 cases: 1 work, 1 refused, 1 said to be wrong, 1 wrong in silence (20.0 %"),
            std::string::npos);
  EXPECT_NE(page.find("| 4 | 0 | 0 | 0 | 1 |"), std::string::npos) << page;
}

}  // namespace
}  // namespace prehend::eval
