#include "eval/touch/paper_figures.h"

#include <cstdio>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prehend::eval::touch {
namespace {

using ::testing::HasSubstr;

CoveredCycle covered_cycle(const StageCycleOptions& options) {
  return {options.coverage, run_stage_cycle(options)};
}

const WorkCycleRuns& paper_runs() {
  static const WorkCycleRuns kRuns{
      StageCycleOptions().grip_force,
      covered_cycle({.coverage = 0.3, .realistic_pads = true, .stuck_drive = true}),
      covered_cycle({.coverage = 0.3}),
      {covered_cycle({.coverage = 0.15}), covered_cycle({.coverage = 0.6}),
       covered_cycle({.coverage = 1})}};
  return kRuns;
}

TEST(PaperFigures, AllAgreeAndStandOnThePageBesideThePapers) {
  const WorkCycleRuns& runs = paper_runs();
  for (const PaperFigure& figure :
       {figure_4(runs), figure_5(runs), figure_6(runs), figure_7(runs), figure_8()}) {
    SCOPED_TRACE(figure.number);
    EXPECT_TRUE(figure.agrees());
    EXPECT_GE(figure.comparisons.size(), 2u);
    EXPECT_FALSE(figure.charts.empty() && figure.pictures.empty());
    report::Page page("figures");
    add_figure(figure, &page);
    const std::string html = page.html();
    // A page is long with its pictures: no matcher that would print it.
    const auto has = [&](const std::string& text) { return html.find(text) != std::string::npos; };
    EXPECT_TRUE(has("Figure " + figure.number + ". "));
    EXPECT_TRUE(has("The paper's figure: "));
    EXPECT_TRUE(has("What differs, and why: "));
    EXPECT_TRUE(has("class=\"columns\""));
    EXPECT_EQ(has("<svg"), !figure.charts.empty());
    EXPECT_EQ(has("<img"), !figure.pictures.empty());
    EXPECT_FALSE(has("<td>no</td>"));
  }
}

// What is said comes from the runs: runs that are otherwise are not said to agree.
TEST(PaperFigures, SayWhatOtherRunsShow) {
  WorkCycleRuns runs = paper_runs();
  std::swap(runs.real, runs.simulated);  // real pads that are ideal, simulated ones that are not
  for (const Comparison& comparison : figure_4(runs).comparisons) {
    EXPECT_FALSE(comparison.agrees) << comparison.shown << ": " << comparison.here;
  }
  for (const Comparison& comparison : figure_5(runs).comparisons) {
    if (comparison.shown.starts_with("b: the wanted")) continue;
    EXPECT_FALSE(comparison.agrees) << comparison.shown << ": " << comparison.here;
  }
  for (const Comparison& comparison : figure_6(runs).comparisons) {
    EXPECT_FALSE(comparison.agrees) << comparison.shown << ": " << comparison.here;
  }
  EXPECT_NE(figure_5(runs).differs, figure_5(paper_runs()).differs);

  std::swap(runs.by_coverage.front().cycle, runs.by_coverage.back().cycle);
  const PaperFigure seventh = figure_7(runs);
  EXPECT_FALSE(seventh.comparisons.front().agrees) << "the more, the steeper";
  EXPECT_FALSE(seventh.comparisons.back().agrees) << "the more, the uneasier";
  EXPECT_THAT(seventh.comparisons.back().here, HasSubstr("does not grow"));
  report::Page page("figures");
  add_figure(seventh, &page);
  EXPECT_NE(page.html().find("<td>no</td>"), std::string::npos);
}

// The figures are those of the run's own measures.
TEST(PaperFigures, SayTheRunsFigures) {
  const WorkCycleRuns& runs = paper_runs();
  const auto has = [](const PaperFigure& figure, const std::string& text) {
    for (const Comparison& comparison : figure.comparisons) {
      if (comparison.here.find(text) != std::string::npos) return true;
    }
    return false;
  };
  char text[64];
  std::snprintf(text, sizeof text, "%.2f and %.2f N", runs.real.cycle.held_left,
                runs.real.cycle.held_right);
  EXPECT_TRUE(has(figure_4(runs), text)) << text;
  std::snprintf(text, sizeof text, "after %.2f s", runs.simulated.cycle.settled_after);
  EXPECT_TRUE(has(figure_5(runs), text)) << text;
  std::snprintf(text, sizeof text, "%.0f, %.0f, %.0f N/s", runs.by_coverage[0].cycle.rise,
                runs.by_coverage[1].cycle.rise, runs.by_coverage[2].cycle.rise);
  EXPECT_TRUE(has(figure_7(runs), text)) << text;
}

}  // namespace
}  // namespace prehend::eval::touch
