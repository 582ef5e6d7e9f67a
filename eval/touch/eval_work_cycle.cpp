// The soft-contact paper's work cycle (its figures 4 to 7): both tactile sums over time and tactile
// images at each phase, for starting heights that cover 15, 30, 60 and 100 % of the pad, ideal and
// as they are; with a drive without friction and one that sticks.

#include <algorithm>
#include <cmath>

#include "eval/touch/experiment.h"
#include "eval/touch/stage_cycle.h"
#include "prehend/report/charts.h"
#include "prehend/report/pictures.h"

namespace {

using namespace prehend;
using namespace prehend::eval::touch;
using control::Phase;

constexpr double kCoverages[] = {0.15, 0.3, 0.6, 1.0};

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
Row add_run(const std::string& name, const StageCycleOptions& options, report::Page& page) {
  const StageCycle cycle = run_stage_cycle(options);
  page.add_heading(name);
  page.add_chart(report::draw_line_chart(chart(cycle, name, -1, 5)),
                 "Sums of both pads, as they show them");
  page.add_chart(report::draw_line_chart(chart(cycle, name + ", the rise", -0.1, 0.4)),
                 "Velocity control ends at 0");
  add_images(page, cycle);
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

Findings work_cycle(const ExperimentOptions& options, report::Page& page) {
  Findings findings;
  findings.title = "work cycle";
  std::vector<Row> rows;
  page.add_paragraph(
      "The paper's figures 5b, 6 and 7 (simulated): both sums are equal, reach the wanted value "
      "swiftly, rise the more steeply the more of the pad is covered, and jump where velocity "
      "control changes to force control, more so the stiffer the contact.");
  for (const double coverage : kCoverages) {
    StageCycleOptions run;
    run.coverage = coverage;
    rows.push_back(add_run(number_text(100 * coverage) + " % of the pad", run, page));
  }
  page.add_paragraph(
      "The paper's figures 4 and 5a (real, 30 % covered): the sums of the two sensors differ "
      "clearly, and the wanted sum is reached with difficulty, probably by stick and slip in the "
      "gripper. Here the drive sticks by 15 N that its controller does not know of, and gains "
      "differ from pad to pad.");
  for (const bool stuck : {false, true}) {
    StageCycleOptions run;
    run.coverage = 0.3;
    run.realistic_pads = true;
    run.stuck_drive = stuck;
    rows.push_back(add_run(
        std::string("30 % of the pad, realistic pads") + (stuck ? ", a drive that sticks" : ""),
        run, page));
    if (options.quick) break;
  }
  page.add_heading("Figures");
  add_table(page, rows);
  const bool lifted = std::all_of(rows.begin(), rows.end(),
                                  [](const Row& row) { return std::get<bool>(row.back().second); });
  page.add_verdict(lifted ? "The box was lifted and put down each time" : "The box was lost",
                   lifted);
  findings.summary = {{"lifted_each_time", lifted}};
  findings.tables = {{"cycles", rows}};
  return findings;
}

}  // namespace

int main(int argc, char** argv) {
  return run_experiment(argc, argv, "Work cycle of the soft-contact paper", work_cycle);
}
