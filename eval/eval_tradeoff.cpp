// Speed against accuracy: sweeps a stage's knobs where the truth is known, keeps the front, and
// chooses from it.

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <opencv2/core.hpp>

#include "eval/shape_tradeoff.h"
#include "eval/text_files.h"
#include "prehend/fidelity/front.h"
#include "prehend/fidelity/shape_settings.h"
#include "prehend/geometry/errors.h"
#include "prehend/report/charts.h"
#include "prehend/report/page.h"

namespace {

using namespace prehend;
namespace fs = std::filesystem;

struct Options {
  fs::path out = "out/tradeoff";
  fs::path front = "config/fidelity/shape.yaml";
  std::string budget;
  std::string tolerance;
  bool quick = false;
};

std::string knobs_text(const fidelity::Setting& setting) {
  std::string text;
  for (const auto& [name, value] : setting.knobs) {
    text += (text.empty() ? "" : ", ") + name + " " + value;
  }
  return text;
}

std::string processor() {
  std::ifstream stream("/proc/cpuinfo");
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

int choose(const Options& options) {
  const fidelity::Front front = fidelity::read_front(options.front);
  const fidelity::Setting& chosen =
      options.budget.empty()
          ? fidelity::within_tolerance(front, fidelity::parse_metres(options.tolerance))
          : fidelity::within_budget(front, fidelity::parse_seconds(options.budget));
  // Both: the most accurate within the budget must also keep the tolerance.
  if (!options.budget.empty() && !options.tolerance.empty() &&
      chosen.error > fidelity::parse_metres(options.tolerance)) {
    throw fidelity::UnreachableError(
        "No setting keeps both " + options.budget + " and " + options.tolerance,
        fmt::format("Within the budget {:.2f} mm can be reached", 1e3 * chosen.error), chosen);
  }
  (void)fidelity::shape_options(chosen);  // refuses a front that no longer fits the library
  std::printf("%s\n%.1f ms, %.2f mm (%s; %s)\n", knobs_text(chosen).c_str(), 1e3 * chosen.seconds,
              1e3 * chosen.error, front.error_name.c_str(), front.machine.c_str());
  return EXIT_SUCCESS;
}

void write_page(const Options& options, const eval::ShapeTradeoff& tradeoff,
                const fidelity::Front& front) {
  report::LineChart chart{
      "From segmented cloud to mesh", "time [ms]", "mean deviation [mm]", {}, {}};
  report::Series all{"settings", {}, {}, false}, best{"front", {}, {}, true};
  std::string csv = "milliseconds,deviation_mm,failed,objects,knobs\n";
  for (const eval::Measured& m : tradeoff.shape) {
    all.points.emplace_back(1e3 * m.setting.seconds, 1e3 * m.setting.error);
    csv += fmt::format("{:.3f},{:.4f},{},{},\"{}\"\n", 1e3 * m.setting.seconds,
                       1e3 * m.setting.error, m.failed, m.objects, knobs_text(m.setting));
  }
  std::vector<std::vector<std::string>> rows;
  for (const fidelity::Setting& s : front.settings) {
    best.points.emplace_back(1e3 * s.seconds, 1e3 * s.error);
    rows.push_back({fmt::format("{:.1f}", 1e3 * s.seconds), fmt::format("{:.2f}", 1e3 * s.error),
                    knobs_text(s)});
  }
  chart.series = {all, best};
  const std::string svg = report::draw_line_chart(chart);
  report::Page page("Speed against accuracy of predicted shapes");
  page.add_paragraph("Measured on: " + front.machine + ". Deviation: " + front.error_name + ".");
  page.add_chart(svg, "Every setting that was tried, and those that nothing beats");
  page.add_table({"time [ms]", "deviation [mm]", "setting"}, rows);
  page.add_heading("Stereo matching");
  std::vector<std::vector<std::string>> stereo;
  for (const eval::Measured& m : tradeoff.stereo) {
    stereo.push_back({knobs_text(m.setting), fmt::format("{:.0f}", 1e3 * m.setting.seconds),
                      fmt::format("{:.2f}", 1e3 * m.setting.error),
                      fmt::format("{} of {}", m.failed, m.objects)});
  }
  page.add_table({"method", "matching [ms]", "deviation of the default shape [mm]", "no mesh"},
                 stereo);
  eval::write_text(options.out / "shape.csv", csv);
  eval::write_text(options.out / "shape.svg", svg);
  page.write(options.out / "index.html");
}

int sweep(const Options& options) {
  std::vector<eval::EvaluationObject> objects;
  for (eval::EvaluationObject& object : eval::household_objects()) {
    object.lies_too = false;
    // Six of different kinds; the others are like one of them.
    for (const char* name : {"cereal_box", "can", "bottle", "mug", "spray_bottle", "toy"}) {
      if (object.name == name) objects.push_back(object);
    }
  }
  if (options.quick) objects.resize(2);
  const std::vector<eval::DataSet> sets = eval::make_data_sets("household", objects);
  std::vector<eval::Case> cases = eval::make_cases(sets, 8, 1);
  // One orientation each, all different.
  std::vector<eval::Case> chosen;
  for (std::size_t i = 0; i < sets.size(); ++i) chosen.push_back(cases[8 * i + (3 * i + 1) % 8]);
  cv::setNumThreads(1);
  const eval::ShapeTradeoff tradeoff =
      eval::measure_shape_tradeoff(chosen, eval::swept_settings(options.quick),
                                   options.quick ? 1 : 3, [](const std::string& text) {
                                     std::printf("%s\n", text.c_str());
                                     std::fflush(stdout);
                                   });
  const fidelity::Front front = eval::front_of(
      tradeoff,
      fmt::format("{}, processor time, {} rendered household objects", processor(), chosen.size()));
  if (front.settings.empty()) {
    std::fprintf(stderr, "No setting gave a mesh of every object; there is no front.\n");
    return EXIT_FAILURE;
  }
  // A quick look is no measurement to choose from later.
  const fs::path file = options.quick ? options.out / "shape.yaml" : options.front;
  fs::create_directories(options.out);
  fidelity::write_front(file, front);
  write_page(options, tradeoff, front);
  for (const fidelity::Setting& s : front.settings) {
    std::printf("%8.1f ms %6.2f mm  %s\n", 1e3 * s.seconds, 1e3 * s.error, knobs_text(s).c_str());
  }
  for (const eval::Measured& m : tradeoff.stereo) {
    std::printf("%8.0f ms %6.2f mm  %s\n", 1e3 * m.setting.seconds, 1e3 * m.setting.error,
                knobs_text(m.setting).c_str());
  }
  std::printf("%s\n%s\n", file.c_str(), (options.out / "index.html").c_str());
  return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Speed against accuracy where the truth is known.");
  app.require_subcommand(1);
  CLI::App* shape = app.add_subcommand(
      "shape",
      "from segmented cloud to mesh: sweeps the knobs and writes the front; with --budget or "
      "--tolerance chooses from the front that was written");
  shape->add_option("--out", options.out, "folder of the page")->capture_default_str();
  shape->add_option("--front", options.front, "file of the front")->capture_default_str();
  shape->add_option("--budget", options.budget,
                    "choose the most accurate within a time, e.g. 20ms");
  shape->add_option("--tolerance", options.tolerance,
                    "choose the fastest within an error, e.g. 3mm");
  shape->add_flag("--quick", options.quick, "few settings and objects; leaves the front alone");
  CLI11_PARSE(app, argc, argv);
  try {
    const bool choosing = !options.budget.empty() || !options.tolerance.empty();
    return choosing ? choose(options) : sweep(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
}
