// The soft-contact paper's work cycle (its figures 4 to 7): both tactile sums over time and tactile
// images at each phase, for starting heights that cover 15, 30, 60 and 100 % of the pad; with and
// without stiction of the drive; ideal and realistic pads.

#include <algorithm>
#include <cmath>

#include "eval/touch/experiment.h"
#include "prehend/report/charts.h"
#include "prehend/report/pictures.h"
#include "prehend/simulation/tactile_sensor.h"
#include "prehend/simulation/work_cycle.h"

namespace {

using namespace prehend;
using namespace prehend::eval::touch;
using namespace prehend::simulation;

constexpr double kStiction = 3;  // N
constexpr double kGrip = 12;     // N of each jaw

WorkCycleOptions cycle(double coverage, double stiction, bool quick) {
  WorkCycleOptions options;
  options.coverage = coverage;
  options.stiction = stiction;
  options.grip_force = kGrip;
  options.grasp.law.viscous_friction = 0.1;
  options.grasp.law.bristle_law = contact::BristleLaw::kElastoPlastic;
  options.grasp.law.return_map = true;
  options.step.step = quick ? 5e-3 : 1e-3;
  options.sample_period = 0.05;
  return options;
}

report::LineChart chart(const WorkCycleResult& result, const std::string& title) {
  report::LineChart chart;
  chart.title = title;
  chart.x_label = "time [s]";
  chart.y_label = "tactile sum [N]";
  chart.series = {{"left", {}}, {"right", {}}};
  for (const CycleSample& sample : result.samples) {
    chart.series[0].points.emplace_back(sample.time, sample.left);
    chart.series[1].points.emplace_back(sample.time, sample.right);
  }
  chart.markers.push_back({result.touch_time, "force control"});
  for (const PhaseEnd& end : result.ends) {
    // Where force control begins has its own mark; close to it there is no room.
    if (end.sample.phase <= CyclePhase::kClose) continue;
    chart.markers.push_back({end.sample.time, to_string(end.sample.phase)});
  }
  return chart;
}

std::vector<double> counts_of(TactileSensor& sensor, const std::vector<double>& forces) {
  TactileFrameReading frame;
  // Half a second of frames, as a controller would have seen.
  for (int i = 0; i < 15; ++i) frame = sensor.sample(forces, 1.0 / 30);
  return {frame.counts.begin(), frame.counts.end()};
}

void add_images(report::Page& page, const WorkCycleResult& result, bool realistic) {
  TactileSensorOptions options =
      realistic ? TactileSensorOptions::realistic() : TactileSensorOptions{};
  TactileSensor left(options);
  options.seed = 2;
  TactileSensor right(options);
  std::vector<geometry::ColorImage> pictures;
  std::vector<std::string> captions;
  const PhaseEnd& press = result.ends[static_cast<int>(CyclePhase::kPress)];
  const double full = 1.3 / options.newton_per_count *
                      *std::max_element(press.left_image.begin(), press.left_image.end());
  for (const PhaseEnd& end : result.ends) {
    const bool last = end.sample.phase == CyclePhase::kRelease;
    const bool shown = end.sample.phase == CyclePhase::kClose ||
                       end.sample.phase == CyclePhase::kPress ||
                       end.sample.phase == CyclePhase::kHold || last;
    const auto l = counts_of(left, end.left_image), r = counts_of(right, end.right_image);
    if (!shown) continue;
    pictures.push_back(report::draw_tactile(l, 14, 6, full, 10));
    captions.push_back(std::string(to_string(end.sample.phase)) + ", left");
    pictures.push_back(report::draw_tactile(r, 14, 6, full, 10));
    captions.push_back(std::string(to_string(end.sample.phase)) + ", right");
  }
  page.add_pictures(pictures, captions);
}

Findings work_cycle(const ExperimentOptions& options, report::Page& page) {
  Findings findings;
  findings.title = "work cycle";
  std::vector<Row> rows;
  bool all_lifted = true;
  for (const double coverage : {0.15, 0.3, 0.6, 1.0}) {
    for (const double stiction : {0.0, kStiction}) {
      const WorkCycleResult result = run_work_cycle(cycle(coverage, stiction, options.quick));
      const PhaseEnd& hold = result.ends[static_cast<int>(CyclePhase::kHold)];
      const PhaseEnd& retreat = result.ends[static_cast<int>(CyclePhase::kRetreat)];
      const auto touched = std::count_if(hold.left_image.begin(), hold.left_image.end(),
                                         [](double force) { return force > 0; });
      const double lifted = hold.sample.box.z() - retreat.sample.box.z();
      const bool ok = std::abs(lifted - 0.1) < 0.005;
      all_lifted = all_lifted && ok;
      const std::string name = number_text(100 * coverage) + " % of the pad" +
                               (stiction > 0 ? ", stiction " + number_text(stiction) + " N" : "");
      page.add_heading(name);
      page.add_chart(report::draw_line_chart(chart(result, name)), "Sums of both pads");
      add_images(page, result, false);
      if (stiction > 0) {
        page.add_paragraph("The same with realistic pads:");
        add_images(page, result, true);
      }
      rows.push_back({{"coverage_percent", 100 * coverage},
                      {"stiction_N", stiction},
                      {"touch_time_s", result.touch_time},
                      {"left_sum_N", hold.sample.left},
                      {"right_sum_N", hold.sample.right},
                      {"touched_texels", static_cast<double>(touched)},
                      {"lifted_mm", 1e3 * lifted},
                      {"put_down", std::abs(retreat.sample.box.z() - 0.025) < 1e-3},
                      {"times_real_time", result.duration / result.cpu_time}});
    }
  }
  page.add_heading("Figures");
  add_table(page, rows);
  page.add_verdict(all_lifted ? "The cube was lifted each time" : "The cube was lost", all_lifted);
  findings.summary = {{"lifted_each_time", all_lifted}};
  findings.tables = {{"cycles", rows}};
  return findings;
}

}  // namespace

int main(int argc, char** argv) {
  return run_experiment(argc, argv, "Work cycle of the soft-contact paper", work_cycle);
}
