// Slip while holding: how soon the cycle sees it by its pads, how often it is mistaken, and what
// holding harder saves.

#include <algorithm>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "eval/touch/experiment.h"
#include "eval/touch/slip_hold.h"
#include "prehend/text/command_line.h"
#include "prehend/text/knob.h"

namespace {

using namespace prehend::eval::touch;
using prehend::report::Page;
using prehend::touch::HoldSlipOptions;

constexpr double kSlid = 0.003;      // m: before that it is to be seen
constexpr double kNotSlid = 0.0005;  // m: who slides less does not slide

struct Options {
  std::uint32_t seed = 5000;  // thresholds were chosen with 1000 to 1002
  int holds = 4;              // of each shape and kind
  HoldSlipOptions slip;
};

/// An option of the command line for each knob.
struct AddOption {
  CLI::App* app;

  template <class Value>
  void operator()(const prehend::text::Knob<Value>& knob) const {
    std::string name = "--" + std::string(knob.name);
    std::replace(name.begin(), name.end(), '_', '-');
    app->add_option(name, knob.value, std::string(knob.description))
        ->check(
            prehend::text::in_range(static_cast<Value>(knob.least), static_cast<Value>(knob.most)))
        ->capture_default_str();
  }
};

struct Tally {
  int holds = 0, slid = 0, in_time = 0, still = 0, falsely = 0;
  int dropped = 0, dropped_reacting = 0, put_down = 0;
  std::vector<double> slides;  // m, when it was told

  void add(const SlipHoldResult& told, const SlipHoldResult& reacting) {
    if (!told.gripped) return;
    ++holds;
    const bool slides_far = told.slide >= kSlid;
    if (slides_far) {
      ++slid;
      in_time += told.told_at && *told.told_at < kSlid ? 1 : 0;
      if (told.told_at) slides.push_back(*told.told_at);
    } else if (told.slide < kNotSlid) {
      ++still;
      falsely += told.told_at ? 1 : 0;
    }
    dropped += told.dropped ? 1 : 0;
    dropped_reacting += reacting.dropped ? 1 : 0;
    put_down += reacting.put_down ? 1 : 0;
  }
  void add(const Tally& other) {
    holds += other.holds, slid += other.slid, in_time += other.in_time, still += other.still;
    falsely += other.falsely, dropped += other.dropped;
    dropped_reacting += other.dropped_reacting, put_down += other.put_down;
    slides.insert(slides.end(), other.slides.begin(), other.slides.end());
  }
  Row row(const std::string& name) const {
    std::vector<double> sorted = slides;
    std::sort(sorted.begin(), sorted.end());
    const auto percent = [](int part, int of) { return of > 0 ? 100.0 * part / of : 0.0; };
    return {
        {"held", name},
        {"holds", static_cast<double>(holds)},
        {"slid_3_mm", static_cast<double>(slid)},
        {"seen_before_percent", percent(in_time, slid)},
        {"median_slide_when_seen_mm", sorted.empty() ? 0.0 : 1e3 * sorted[(sorted.size() - 1) / 2]},
        {"did_not_slide", static_cast<double>(still)},
        {"false_percent", percent(falsely, still)},
        {"dropped", static_cast<double>(dropped)},
        {"dropped_when_held_harder", static_cast<double>(dropped_reacting)},
        {"put_down_again", static_cast<double>(put_down)}};
  }
};

constexpr HeldShape kShapes[] = {HeldShape::kBox, HeldShape::kSlanted, HeldShape::kBall,
                                 HeldShape::kCan, HeldShape::kBottle,  HeldShape::kCoveringBox};
constexpr HoldKind kKinds[] = {HoldKind::kSlipsWhenLifted, HoldKind::kSlipsWhenShaken,
                               HoldKind::kHeldStill, HoldKind::kHeldShaken};

Findings slip(const Options& options, Page& page) {
  const auto count = static_cast<std::uint32_t>(options.holds);
  Findings findings;
  findings.title = "slip while holding";
  std::vector<Row> rows;
  Tally all;
  const auto run = [&options, count](HeldShape shape, bool area_texels) {
    Tally tally;
    for (const HoldKind kind : kKinds) {
      for (std::uint32_t i = 0; i < count; ++i) {
        SlipHold hold = random_slip_hold(shape, kind, options.seed + i);
        hold.area_texels = area_texels;
        tally.add(run_slip_hold(hold, false, options.slip),
                  run_slip_hold(hold, true, options.slip));
      }
    }
    return tally;
  };
  for (const HeldShape shape : kShapes) {
    const Tally tally = run(shape, true);
    rows.push_back(tally.row(to_string(shape)));
    if (shape != HeldShape::kCoveringBox) all.add(tally);
  }
  rows.push_back(all.row("all but the box that covers the pads"));
  Tally rays;
  for (const HeldShape shape : kShapes) {
    if (shape != HeldShape::kCoveringBox) rays.add(run(shape, false));
  }
  rows.push_back(rays.row("the same by texels of one ray"));
  for (const auto& [name, value] : all.row("")) {
    if (name != "held") findings.summary.emplace_back(name, value);
  }
  page.add_paragraph(
      "Random things are gripped by the PG70, lifted by 0.1 m, shaken and held by the cycle as it "
      "ships; half of them slide. Seen before 3 mm of slide (goal 95 %), said of what slides less "
      "than 0.5 mm (goal 1 %), and what fell out of the hand: where the cycle only says that it "
      "slips, and where it holds harder.");
  add_table(page, rows);
  findings.tables = {{"shapes", rows}};
  return findings;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  return run_experiment(
      argc, argv, "Slip while holding",
      [&options](const ExperimentOptions& experiment, Page& page) {
        if (experiment.quick) options.holds = 1;
        return slip(options, page);
      },
      [&options](CLI::App& app) {
        app.add_option("--seed", options.seed, "of the first hold of each shape and kind")
            ->capture_default_str();
        app.add_option("--holds", options.holds, "of each shape and kind")
            ->check(prehend::text::in_range(1, 1000))
            ->capture_default_str()
            ->excludes("--quick");
        HoldSlipOptions::knobs(options.slip, AddOption{&app});
      });
}
