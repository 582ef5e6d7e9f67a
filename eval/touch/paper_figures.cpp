#include "eval/touch/paper_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <Eigen/Geometry>

#include "eval/touch/imprints.h"
#include "eval/touch/pressing.h"
#include "prehend/report/charts.h"
#include "prehend/report/pictures.h"
#include "prehend/simulation/tactile_sensor.h"
#include "prehend/touch/imprint.h"

namespace prehend::eval::touch {
namespace {

using control::Phase;

constexpr double kClearly = 0.05;  // two things that differ by this share differ clearly
constexpr double kEqual = 0.005;   // and by less than this are equal
constexpr double kSwiftly = 1;     // s of force control, at most
constexpr double kHarder = 1.3;    // times as long: reached with difficulty
constexpr int kRows = 14, kColumns = 6;
constexpr int kChartWidth = 560;  // pixels, of a column

double mean_held(const StageCycle& cycle) { return (cycle.held_left + cycle.held_right) / 2; }
double sums_differ(const StageCycle& cycle) {
  return std::abs(cycle.held_left - cycle.held_right) / mean_held(cycle);
}
double missed(const StageCycle& cycle, double force) { return mean_held(cycle) / force - 1; }

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// Texels of an image that are covered whole: those above half of the greatest.
std::vector<std::size_t> covered(const std::vector<double>& image) {
  const double half = *std::max_element(image.begin(), image.end()) / 2;
  std::vector<std::size_t> texels;
  for (std::size_t i = 0; i < image.size(); ++i) {
    if (image[i] > half) texels.push_back(i);
  }
  return texels;
}

// Standard deviation of the covered texels over their mean.
double unevenness(const std::vector<double>& image) {
  std::vector<double> values, squares;
  for (const std::size_t i : covered(image)) values.push_back(image[i]);
  const double middle = mean(values);
  for (const double value : values) squares.push_back(std::pow(value - middle, 2));
  return std::sqrt(mean(squares)) / middle;
}

// Root mean square of the difference of texels that face one another, over their mean.
double texels_differ(const PadImages& images) {
  std::vector<double> squares, values;
  for (const std::size_t i : covered(images.left)) {
    squares.push_back(std::pow(images.left[i] - images.right[i], 2));
    values.push_back((images.left[i] + images.right[i]) / 2);
  }
  return std::sqrt(mean(squares)) / mean(values);
}

// How often the jaws stood and went on between the touch and the lift.
int standstills(const StageCycle& cycle) {
  constexpr double kStill = 0.5e-6;  // m, of a sample's 10 ms
  constexpr int kLong = 4;           // samples
  int still = 0, times = 0;
  const StageCycleSample* last = nullptr;
  for (const StageCycleSample& sample : cycle.samples) {
    if (sample.time < cycle.touch_time) continue;
    if (sample.time > cycle.lift_time) break;
    if (last) {
      const bool moves = std::abs(sample.opening - last->opening) > kStill;
      if (moves && still >= kLong) ++times;
      still = moves ? 0 : still + 1;
    }
    last = &sample;
  }
  return times;
}

// How far the mean of the sums goes above what is wanted between the touch and the lift [N].
double overshoot(const StageCycle& cycle, double force) {
  double most = 0;
  for (const StageCycleSample& sample : cycle.samples) {
    if (sample.time >= cycle.touch_time && sample.time <= cycle.lift_time) {
      most = std::max(most, sample.mean() - force);
    }
  }
  return most;
}

using Points = std::vector<std::pair<double, double>>;

// Of a run's samples, against the time since force control began.
template <class Value>
Points over_time(const StageCycle& cycle, double from, double to, const Value& value) {
  Points points;
  for (const StageCycleSample& sample : cycle.samples) {
    const double time = sample.time - cycle.touch_time;
    if (time >= from && time <= to) points.emplace_back(time, value(sample));
  }
  return points;
}

std::string sums_chart(const std::string& title, const StageCycle& cycle) {
  report::LineChart chart{title,      "time of force control [s]", "tactile sum [N]", {}, {},
                          kChartWidth};
  constexpr double kFrom = -0.5, kTo = 4;  // s
  chart.series = {{"left", over_time(cycle, kFrom, kTo, [](const auto& s) { return s.left; })},
                  {"right", over_time(cycle, kFrom, kTo, [](const auto& s) { return s.right; })}};
  const double lift = cycle.lift_time - cycle.touch_time;
  if (lift < kTo) chart.markers = {{lift, "lift"}};
  return report::draw_line_chart(chart);
}

void add_texels(const StageCycle& cycle, PaperFigure* figure) {
  const PadImages& images = cycle.images.at(Phase::kGrasp);
  double full = 1;
  for (const auto* image : {&images.left, &images.right}) {
    full = std::max(full, *std::max_element(image->begin(), image->end()));
  }
  figure->pictures = {report::draw_tactile(images.left, kRows, kColumns, full),
                      report::draw_tactile(images.right, kRows, kColumns, full)};
  figure->captions = {"left pad, end of the grasp", "right pad, end of the grasp"};
}

std::string percent(double share) { return fmt::format("{:.1f} %", 100 * share); }

bool increases(const std::vector<double>& values) {
  return std::is_sorted(values.begin(), values.end(), std::less_equal<>());
}

}  // namespace

bool PaperFigure::agrees() const {
  return std::all_of(comparisons.begin(), comparisons.end(),
                     [](const Comparison& comparison) { return comparison.agrees; });
}

PaperFigure figure_4(const WorkCycleRuns& runs) {
  const StageCycle& real = runs.real.cycle;
  const PadImages& images = real.images.at(Phase::kGrasp);
  const double texels = texels_differ(images), sums = sums_differ(real);
  const auto pads = simulation::TactileSensorOptions::realistic();
  PaperFigure figure;
  figure.number = "4";
  figure.subject = fmt::format("Real pads, {:.0f} % covered: texels", 100 * runs.real.coverage);
  figure.paper =
      "Measured with the real gripper: the texels of both sensors while a cube is held. The same "
      "grip looks clearly different to the two.";
  figure.comparisons = {
      {"facing texels of the two sensors differ clearly",
       "by " + percent(texels) + " of their mean (root mean square)", texels > kClearly},
      {"so do the two sums",
       fmt::format("{:.2f} and {:.2f} N, {} apart", real.held_left, real.held_right, percent(sums)),
       sums > kClearly}};
  figure.differs = fmt::format(
      "How far the paper's sensors were apart is not published. Ours are simulated: gains of "
      "texels and pads are drawn (standard deviations {:.0f} and {:.0f} %), loads spread over "
      "{:.1f} mm, foam creeps and has hysteresis. These are estimates, and so are the {} that come "
      "of them. Texels of one pad scatter by {} and {} here.",
      100 * pads.gain_spread, 100 * pads.pad_gain_spread, 1e3 * pads.spread, percent(sums),
      percent(unevenness(images.left)), percent(unevenness(images.right)));
  add_texels(real, &figure);
  return figure;
}

PaperFigure figure_5(const WorkCycleRuns& runs) {
  const StageCycle &real = runs.real.cycle, &simulated = runs.simulated.cycle;
  // Of one that never settles, the time of force control until the lift is its time.
  const bool reached = real.settled_after < real.lift_time - real.touch_time;
  const int stands = standstills(real), stands_simulated = standstills(simulated);
  PaperFigure figure;
  figure.number = "5";
  figure.subject = "Sums of both pads: a real, b simulated";
  figure.paper =
      "Both tactile sums over the work cycle. Real: the two lie apart, and the sum that is wanted "
      "is "
      "reached with difficulty, which the authors put down to the gripper's stick and slip. "
      "Simulated: the sums are equal and reach it swiftly.";
  figure.comparisons = {
      {"a: the sums lie apart", percent(sums_differ(real)), sums_differ(real) > kClearly},
      {"a: the wanted sum is reached with difficulty",
       fmt::format("{} after {:.2f} s, {:.1f} times b's",
                   reached ? "within 2 % of it" : "not within 2 % of it when lifted,",
                   real.settled_after, real.settled_after / simulated.settled_after),
       real.settled_after > kHarder * simulated.settled_after},
      {"a: the gripper sticks and slips",
       fmt::format("how often the jaws stand and go on: {}, {} in b", stands, stands_simulated),
       stands > stands_simulated},
      {"b: the sums are equal", percent(sums_differ(simulated)) + " apart",
       sums_differ(simulated) < kEqual},
      {"b: the wanted sum is reached swiftly",
       fmt::format("after {:.2f} s, {} off", simulated.settled_after,
                   percent(std::abs(missed(simulated, runs.grip_force)))),
       simulated.settled_after < kSwiftly}};
  figure.differs = fmt::format(
      "In a the sum stays {} off {:.0f} N: the controller stops where the drive, which sticks by "
      "{:.0f} N more than it was told, does not move any more. The paper's stiction is not "
      "published: "
      "this one is ours. Its cycle took 45 s, ours {:.0f} s, as the stage moves faster.",
      percent(std::abs(missed(real, runs.grip_force))), runs.grip_force, kHiddenStiction,
      real.samples.back().time);
  figure.charts = {sums_chart("a: pads and drive as they are", real),
                   sums_chart("b: ideal pads and drive", simulated)};
  return figure;
}

PaperFigure figure_6(const WorkCycleRuns& runs) {
  const StageCycle& simulated = runs.simulated.cycle;
  const PadImages& images = simulated.images.at(Phase::kGrasp);
  const double uneven = std::max(unevenness(images.left), unevenness(images.right));
  const double uneven_real = unevenness(runs.real.cycle.images.at(Phase::kGrasp).left);
  PaperFigure figure;
  figure.number = "6";
  figure.subject =
      fmt::format("Simulated pads, {:.0f} % covered: texels", 100 * runs.simulated.coverage);
  figure.paper =
      "Simulated texels of the two sensors during the cycle: loads are even over what is covered "
      "and "
      "the same on both sides, which real ones are not.";
  figure.comparisons = {
      {"covered texels bear the same",
       fmt::format("they scatter by {} of their mean, in figure 4 by {}", percent(uneven),
                   percent(uneven_real)),
       uneven < kClearly && uneven < uneven_real},
      {"both sides show the same", "facing texels are " + percent(texels_differ(images)) + " apart",
       texels_differ(images) < kEqual}};
  figure.differs = fmt::format(
      "Covered texels are told by half of the greatest count: {} here, {} of {} rows. What the "
      "paper "
      "leaves out of its simulation (stiction, hysteresis, the foam's spread, creep, noise, spread "
      "from sensor to sensor, ageing) is left out of this run, too, and is what makes figure 4.",
      covered(images.left).size(), covered(images.left).size() / kColumns, kRows);
  add_texels(simulated, &figure);
  return figure;
}

PaperFigure figure_7(const WorkCycleRuns& runs) {
  std::vector<double> rises, jumps, overshoots;
  std::vector<std::string> names;
  report::LineChart chart{"",         "time of force control [s]", "mean of the sums [N]", {}, {},
                          kChartWidth};
  for (const auto& [coverage, cycle] : runs.by_coverage) {
    rises.push_back(cycle.rise);
    jumps.push_back(cycle.jump);
    overshoots.push_back(overshoot(cycle, runs.grip_force));
    names.push_back(fmt::format("{:.0f}", 100 * coverage));
    chart.series.push_back(
        {names.back() + " %", over_time(cycle, -0.1, 0.4, [](const auto& s) { return s.mean(); })});
  }
  PaperFigure figure;
  figure.number = "7";
  figure.subject = fmt::format("Simulated: {} % of the pads covered", fmt::join(names, ", "));
  figure.paper =
      "The height at which the cube is grasped decides how much of the pads touches: 15, 60 and "
      "100 "
      "%. The more does, the stiffer the contact and the steeper the rise. Where velocity control "
      "gives way to force control the sum jumps, and the change is the less smooth the stiffer the "
      "contact is.";
  figure.comparisons = {
      {"the more is covered, the steeper the rise",
       fmt::format("{:.0f} N/s", fmt::join(rises, ", ")), increases(rises)},
      {"the sum jumps where control changes",
       fmt::format("by {:.1f} N in the first 20 ms", fmt::join(jumps, ", ")),
       std::all_of(jumps.begin(), jumps.end(),
                   [&](double jump) { return jump > kClearly * runs.grip_force; })},
      {"the stiffer, the uneasier the change", "that jump grows with what is covered",
       increases(jumps)}};
  if (!increases(jumps)) figure.comparisons.back().here = "that jump does not grow";
  const bool calmer = overshoots.back() < overshoots.front();
  figure.differs = fmt::format(
      "Uneasy is the jump alone: what is wanted, {:.0f} N, is exceeded by {:.2f} N, {}, as "
      "our controller's gains make it. The stiffest contact rises {:.1f} times as steeply as "
      "the softest, with {:.1f} times the texels: the rest is the controller's and the drive's, "
      "which are ours. The paper gives no values to compare.",
      runs.grip_force, fmt::join(overshoots, ", "),
      calmer ? "not most by the stiffest" : "most by the stiffest", rises.back() / rises.front(),
      runs.by_coverage.back().coverage / runs.by_coverage.front().coverage);
  figure.charts = {report::draw_line_chart(chart)};
  return figure;
}

PaperFigure figure_8() {
  constexpr double kTurn = 0.3;                // rad
  const Eigen::Vector2d middle(0.002, 0.004);  // m, of the block, in the pads' plane
  PaperFigure figure;
  figure.number = "8";
  figure.subject = "A cross on one side, a square on the other";
  figure.paper =
      "A cube with a hole in the shape of a cross in one side and a square one in the other, "
      "between "
      "the pads: both shapes can be seen in the images. The two sides bear differently, since the "
      "cube was not centred and stuck to the table.";
  const std::array<const Hole*, 2> sides{&holes()[0], &holes()[1]};
  const contact::Shape block = contact::Shape::mesh(
      perforated_block({0.08, 0.04, 0.08}, {sides[0], {0, 0}}, {sides[1], {0, 0}}));
  geometry::RigidTransform X_GB = geometry::RigidTransform::Identity();
  X_GB.linear() = Eigen::AngleAxisd(kTurn, Eigen::Vector3d::UnitY()).matrix();
  X_GB.translation() = Eigen::Vector3d(middle.x(), 0, middle.y());
  std::array<double, 2> differ{}, right{};
  for (const bool realistic : {false, true}) {
    Presser presser({.realistic = realistic});
    const auto pressed = presser.press(block, X_GB);
    if (!pressed) throw std::runtime_error("figure 8: the block was not pressed");
    std::array<double, 2> sums{};
    for (const std::size_t side : {0, 1}) {
      const std::vector<double> counts(pressed->frames[side].begin(), pressed->frames[side].end());
      for (const double count : counts) sums[side] += count * presser.pad().newton_per_count;
      const auto imprint = imprint_of(presser.pad(), felt_texels(presser.pad(), counts));
      if (!imprint) throw std::runtime_error("figure 8: the block left no imprint");
      for (std::size_t i = 0; i < counts.size(); ++i) {
        // Pads are flat, x across and y along: x and z of the gripper; that at -y faces it, its
        // columns run against x.
        const Eigen::Vector3d p_P = presser.pad().layout.position(i);
        const Eigen::Vector3d p_G(side == 0 ? p_P.x() : -p_P.x(), 0, p_P.y());
        const Eigen::Vector3d p_B = X_GB.inverse() * p_G;
        const bool hole = sides[side]->contains({p_B.x(), p_B.z()});
        right[realistic] += (imprint->pressed[i] < 0.5) == hole ? 0.5 / counts.size() : 0;
      }
      const double full = *std::max_element(counts.begin(), counts.end());
      figure.pictures.push_back(report::draw_tactile(counts, kRows, kColumns, full));
      figure.captions.push_back(
          fmt::format("{}, {} pads", sides[side]->name, realistic ? "realistic" : "ideal"));
    }
    differ[realistic] = 2 * std::abs(sums[0] - sums[1]) / (sums[0] + sums[1]);
  }
  constexpr double kShown = 0.95;  // of the texels
  figure.comparisons = {
      {"the images show the shapes",
       fmt::format(
           "{} of the texels of ideal pads and {} of realistic ones say rightly whether the "
           "hole is before them",
           percent(right[0]), percent(right[1])),
       right[0] > kShown && right[1] > kShown},
      {"the two sides bear differently",
       fmt::format("their sums differ by {} on realistic pads, {} on ideal ones",
                   percent(differ[1]), percent(differ[0])),
       differ[1] > kClearly}};
  figure.differs = fmt::format(
      "Here the block floats between the pads, {:.0f} mm off their middle and turned by {:.1f} "
      "rad, so "
      "that both sides bear the same force; what differs is what the pads say of it, by their "
      "gains. "
      "The paper's cube stood on a table and was pushed against it, by forces that are not "
      "published.",
      1e3 * middle.norm(), kTurn);
  return figure;
}

void add_figure(const PaperFigure& figure, report::Page* page) {
  page->add_heading("Figure " + figure.number + ". " + figure.subject);
  report::Page left(""), right("");
  for (const std::string& chart : figure.charts) left.add_chart(chart, "");
  if (!figure.pictures.empty()) left.add_pictures(figure.pictures, figure.captions);
  right.add_paragraph("The paper's figure: " + figure.paper);
  std::vector<std::vector<std::string>> rows;
  for (const Comparison& comparison : figure.comparisons) {
    rows.push_back({comparison.shown, comparison.here, comparison.agrees ? "yes" : "no"});
  }
  right.add_table({"the paper's shows", "here", "agrees"}, rows);
  right.add_paragraph("What differs, and why: " + figure.differs);
  page->add_columns(left, right);
}

}  // namespace prehend::eval::touch
