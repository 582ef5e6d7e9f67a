// The soft-contact paper's work cycle and imprints: its figures 4 to 8 beside ours, then every run:
// both tactile sums over time and tactile images at each phase, for starting heights that cover 15,
// 30, 60 and 100 % of the pad, ideal and as they are; with a drive without friction and one that
// sticks.

#include <algorithm>
#include <cmath>

#include "eval/touch/experiment.h"
#include "eval/touch/paper_figures.h"
#include "eval/touch/stage_cycle.h"
#include "prehend/report/charts.h"
#include "prehend/report/pictures.h"

namespace {

using namespace prehend;
using namespace prehend::eval::touch;
using control::Phase;

constexpr double kRealCoverage = 0.3;  // of the paper's figures 4 to 6; the others are figure 7's
constexpr double kCoverages[] = {0.15, kRealCoverage, 0.6, 1.0};

// Time 0 is where force control begins.
report::LineChart chart(const StageCycle& cycle, const std::string& title, double from, double to) {
  report::LineChart chart;
  chart.title = title;
  chart.x_label = "time of force control [s]";
  chart.y_label = "tactile sum [N]";
  chart.series = {{"left", {}}, {"right", {}}};
  for (const StageCycleSample& sample : cycle.samples) {
    const double time = sample.time - cycle.touch_time;
    if (time < from || time > to) continue;
    chart.series[0].points.emplace_back(time, sample.left);
    chart.series[1].points.emplace_back(time, sample.right);
  }
  const double lift = cycle.lift_time - cycle.touch_time;
  if (lift < to) chart.markers = {{lift, "lift"}};
  return chart;
}

void add_images(report::Page& page, const StageCycle& cycle) {
  std::vector<geometry::ColorImage> pictures;
  std::vector<std::string> captions;
  double full = 1;
  for (const auto& [phase, images] : cycle.images) {
    for (const auto* image : {&images.left, &images.right}) {
      for (const double counts : *image) full = std::max(full, counts);
    }
  }
  for (const Phase phase : {Phase::kGrasp, Phase::kLift, Phase::kMove}) {
    const auto images = cycle.images.find(phase);
    if (images == cycle.images.end()) continue;
    pictures.push_back(report::draw_tactile(images->second.left, 14, 6, full, 10));
    captions.push_back(std::string("end of ") + control::to_string(phase) + ", left");
    pictures.push_back(report::draw_tactile(images->second.right, 14, 6, full, 10));
    captions.push_back(std::string("end of ") + control::to_string(phase) + ", right");
  }
  page.add_pictures(pictures, captions);
}

// The run's figures as a row.
Row row_of(const StageCycle& cycle, const StageCycleOptions& options) {
  const double mean = (cycle.held_left + cycle.held_right) / 2;
  return {{"coverage_percent", 100 * options.coverage},
          {"pads", options.realistic_pads ? "realistic" : "ideal"},
          {"drive", options.stuck_drive ? "sticks" : "ideal"},
          {"rise_N_per_s", cycle.rise},
          {"settled_after_s", cycle.settled_after},
          {"jump_N", cycle.jump},
          {"left_N", cycle.held_left},
          {"right_N", cycle.held_right},
          {"differ_percent", 100 * std::abs(cycle.held_left - cycle.held_right) / mean},
          {"missed_percent", 100 * (mean / options.grip_force - 1)},
          {"raised_mm", 1e3 * cycle.raised},
          {"put_down", cycle.result.success()}};
}

void add_run(const StageCycle& cycle, const std::string& name, report::Page& page) {
  page.add_heading(name);
  page.add_chart(report::draw_line_chart(chart(cycle, name, -1, 5)),
                 "Sums of both pads, as they show them");
  page.add_chart(report::draw_line_chart(chart(cycle, name + ", the rise", -0.1, 0.4)),
                 "Velocity control ends at 0");
  add_images(page, cycle);
}

// The paper's figures beside ours; returns what was compared.
std::vector<Row> add_figures(const WorkCycleRuns& runs, report::Page& page, Row* summary) {
  std::vector<Row> rows;
  for (const PaperFigure& figure :
       {figure_4(runs), figure_5(runs), figure_6(runs), figure_7(runs), figure_8()}) {
    add_figure(figure, &page);
    summary->push_back({"figure_" + figure.number + "_agrees", figure.agrees()});
    for (const Comparison& comparison : figure.comparisons) {
      rows.push_back({{"figure", figure.number},
                      {"shown", comparison.shown},
                      {"here", comparison.here},
                      {"agrees", comparison.agrees}});
    }
  }
  return rows;
}

Findings work_cycle(const ExperimentOptions& options, report::Page& page) {
  Findings findings;
  findings.title = "work cycle";
  struct Run {
    std::string name;
    StageCycleOptions options;
    StageCycle cycle;
  };
  std::vector<Run> all;
  WorkCycleRuns runs;
  for (const double coverage : kCoverages) {
    all.push_back({number_text(100 * coverage) + " % of the pad", {.coverage = coverage}, {}});
  }
  for (const bool stuck : {false, true}) {
    if (!stuck && options.quick) continue;
    all.push_back(
        {std::string("30 % of the pad, realistic pads") + (stuck ? ", a drive that sticks" : ""),
         {.coverage = kRealCoverage, .realistic_pads = true, .stuck_drive = stuck},
         {}});
  }
  std::vector<Row> rows;
  for (Run& run : all) {
    run.cycle = run_stage_cycle(run.options);
    rows.push_back(row_of(run.cycle, run.options));
    const CoveredCycle covered{run.options.coverage, run.cycle};
    runs.grip_force = run.options.grip_force;
    if (run.options.stuck_drive) runs.real = covered;
    if (run.options.realistic_pads) continue;
    if (run.options.coverage == kRealCoverage) {
      runs.simulated = covered;
    } else {
      runs.by_coverage.push_back(covered);
    }
  }
  const bool lifted = std::all_of(all.begin(), all.end(),
                                  [](const Run& run) { return run.cycle.result.success(); });
  findings.summary = {{"lifted_each_time", lifted}};
  page.add_paragraph(
      "What Moisio, León, Korkealaakso and Morales show of their tactile sensor model, beside the "
      "same experiments with what ships. All values are of this run. Its text tells what figures 4 "
      "and 5a have in common, and 5b and 6; what of it is texels and what sums is our reading.");
  const std::vector<Row> figures = add_figures(runs, page, &findings.summary);
  for (const Run& run : all) add_run(run.cycle, "Run: " + run.name, page);
  page.add_heading("All runs");
  add_table(page, rows);
  page.add_verdict(lifted ? "The box was lifted and put down each time" : "The box was lost",
                   lifted);
  findings.tables = {{"figures", figures}, {"cycles", rows}};
  return findings;
}

}  // namespace

int main(int argc, char** argv) {
  return run_experiment(argc, argv, "Work cycle of the soft-contact paper", work_cycle);
}
