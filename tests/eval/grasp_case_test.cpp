#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "eval/grasp/grasp_case.h"
#include "eval/grasp/grasp_report.h"
#include "prehend/geometry/errors.h"
#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

GraspTrial trial_of(const std::string& setting, int grasps, int attempts, bool lifted) {
  GraspTrial trial;
  trial.setting = setting;
  trial.grasps = grasps;
  trial.attempts = attempts;
  trial.lifted = lifted;
  trial.best_robustness = grasps > 0 ? 0.9 : 0;
  trial.outcome = "said \"so\": 12.5 N";
  return trial;
}

GraspCase case_of(const std::string& object, std::vector<GraspTrial> trials) {
  GraspCase one;
  one.case_name = object + "-000";
  one.group = "household";
  one.data_set = object;
  one.platform = "stage_pg70";
  one.predict_seconds = 0.25;
  one.trials = std::move(trials);
  return one;
}

TEST(GraspCase, IsReadAsItWasWritten) {
  GraspCase written = case_of("can", {trial_of("predicted", 3, 2, true)});
  written.others = 2;
  written.trials[0].slip = 0.0012345678901234;
  written.trials[0].stage = "lift";
  written.trials[0].surprises = {{control::SurpriseKind::kTactileSum, 8, 5.25, 0, true, ""},
                                 {control::SurpriseKind::kMotion, 1, std::nan(""), 0, false, ""}};
  const GraspCase read = read_grasp_case(to_text(written));
  EXPECT_EQ(read.case_name, written.case_name);
  EXPECT_EQ(read.platform, "stage_pg70");
  EXPECT_EQ(read.others, 2);
  ASSERT_EQ(read.trials.size(), 1u);
  EXPECT_EQ(read.trials[0].outcome, written.trials[0].outcome);
  EXPECT_EQ(read.trials[0].slip, written.trials[0].slip);
  EXPECT_TRUE(std::isnan(read.trials[0].contact_error));
  EXPECT_EQ(read.trials[0].stage, "lift");
  ASSERT_EQ(read.trials[0].surprises.size(), 2u);
  EXPECT_EQ(read.trials[0].surprises[0].kind, control::SurpriseKind::kTactileSum);
  EXPECT_EQ(read.trials[0].surprises[0].predicted, 8);
  EXPECT_EQ(read.trials[0].surprises[0].felt, 5.25);
  EXPECT_TRUE(read.trials[0].surprises[0].surprising);
  EXPECT_EQ(read.trials[0].surprises[1].kind, control::SurpriseKind::kMotion);
  EXPECT_TRUE(std::isnan(read.trials[0].surprises[1].felt));
  EXPECT_TRUE(read.trials[0].lifted);
  EXPECT_FALSE(read.trials[0].lifted_at_first());
  EXPECT_THROW(read_grasp_case("[1, 2]\n"), geometry::InputError);
  const int last = static_cast<int>(control::SurpriseKind::kSlip);
  for (const int kind : {-1, last + 1}) {
    written.trials[0].surprises[0].kind = static_cast<control::SurpriseKind>(kind);
    EXPECT_THROW(read_grasp_case(to_text(written)), geometry::InputError) << kind;
  }
}

TEST(GraspTotals, CountOnlyObjectsThatFit) {
  const std::vector<GraspCase> cases{
      case_of("can", {trial_of("predicted", 3, 1, true), trial_of("truth", 5, 1, true)}),
      case_of("box", {trial_of("predicted", 2, 2, true), trial_of("truth", 5, 1, true)}),
      case_of("jar", {trial_of("predicted", 0, 0, false), trial_of("truth", 5, 1, true)}),
      case_of("tub", {trial_of("predicted", 3, 1, true), trial_of("truth", 0, 0, false)})};
  const auto totals = grasp_totals(cases);
  ASSERT_EQ(totals.size(), 2u);
  EXPECT_EQ(totals[0].setting, "predicted");
  EXPECT_EQ(totals[0].cases, 3);
  EXPECT_EQ(totals[0].first, 1);
  EXPECT_EQ(totals[0].within_three, 2);
  EXPECT_EQ(totals[0].unplanned, 1);
  EXPECT_NE(grasp_text(cases).find("missed: stage_pg70: 33.3 % at the first attempt"),
            std::string::npos)
      << grasp_text(cases);
  std::vector<GraspCase> with_area = cases;
  with_area[0].trials[0].area_error = -0.125;
  with_area[0].trials[0].opening_error = 0.002;
  EXPECT_EQ(grasp_totals(with_area)[0].area_error, 0.125);
  const testing::TemporaryFolder folder;
  write_grasp_report(folder.path, with_area);
  std::ifstream csv(folder.path / "cases.csv");
  std::string header, first;
  std::getline(csv, header);
  std::getline(csv, first);
  EXPECT_NE(header.find("area_error,opening_error_m"), std::string::npos);
  EXPECT_NE(first.find("-0.125,0.002"), std::string::npos) << first;
  EXPECT_TRUE(std::filesystem::exists(folder.path / "index.html"));
  EXPECT_TRUE(std::filesystem::exists(folder.path / "cases.csv"));
}

TEST(GraspTotals, WhatWasPlannedOnlySaysWhatFitsAndIsNotCounted) {
  GraspTrial truth = trial_of("truth", 5, 0, false), narrow = truth;
  truth.is_planned_only = narrow.is_planned_only = true;
  narrow.best_robustness = 0.4;
  const std::vector<GraspCase> cases{case_of("can", {trial_of("predicted", 3, 1, true), truth}),
                                     case_of("tub", {trial_of("predicted", 3, 1, true), narrow})};
  const auto totals = grasp_totals(cases);
  ASSERT_EQ(totals.size(), 1u);
  EXPECT_EQ(totals[0].setting, "predicted");
  EXPECT_EQ(totals[0].cases, 1);
  EXPECT_EQ(grasp_text(cases).find("truth"), std::string::npos) << grasp_text(cases);
  // One of one, after Wilson.
  EXPECT_NE(grasp_text(cases).find("20.7 to 100.0"), std::string::npos) << grasp_text(cases);
  EXPECT_TRUE(read_grasp_case(to_text(cases[0])).trials[1].is_planned_only);
}

TEST(GraspTotals, AreOfEachGroupAndOfAll) {
  std::vector<GraspCase> cases{
      case_of("can", {trial_of("predicted", 3, 1, true), trial_of("truth", 5, 1, true)}),
      case_of("can", {trial_of("predicted", 3, 3, false), trial_of("truth", 5, 1, true)})};
  cases[1].group = "hard";
  cases[1].others = 1;
  const auto totals = grasp_totals(cases);
  ASSERT_EQ(totals.size(), 6u);  // two settings of each
  EXPECT_EQ(totals[0].group, "household");
  EXPECT_EQ(totals[0].first, 1);
  EXPECT_EQ(totals[2].group, "hard");
  EXPECT_EQ(totals[2].first, 0);
  EXPECT_EQ(totals[2].cases, 1);
  EXPECT_EQ(totals[4].group, "all");
  EXPECT_EQ(totals[4].cases, 2);
  EXPECT_NE(grasp_text(cases).find("1 fixed"), std::string::npos) << grasp_text(cases);
}

}  // namespace
}  // namespace prehend::eval
