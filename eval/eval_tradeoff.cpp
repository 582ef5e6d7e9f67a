// Speed against accuracy: sweeps a stage's knobs where the truth is known, keeps the front, and
// chooses from it.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <opencv2/core.hpp>

#include "eval/case_runs.h"
#include "eval/grasp/chain_sweep.h"
#include "eval/grasp/plan_tradeoff.h"
#include "eval/household_objects.h"
#include "eval/shape_tradeoff.h"
#include "eval/text_files.h"
#include "eval/touch/tradeoff.h"
#include "eval/touch/tradeoff_page.h"
#include "prehend/fidelity/chain_settings.h"
#include "prehend/fidelity/chosen_chain.h"
#include "prehend/fidelity/front.h"
#include "prehend/fidelity/plan_settings.h"
#include "prehend/fidelity/shape_settings.h"
#include "prehend/fidelity/touch_settings.h"
#include "prehend/geometry/errors.h"
#include "prehend/report/charts.h"
#include "prehend/report/page.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/command_line.h"
#include "prehend/text/quantities.h"
#include "prehend/text/tree_file.h"

namespace {

using namespace prehend;
namespace fs = std::filesystem;

struct Options {
  eval::CaseRunOptions runs{
      .out = "out/tradeoff",
      .processes = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))};
  fs::path front;
  std::string budget;
  std::string tolerance;
  bool quick = false;
  std::string platform = "stage_pg70";
  std::string from;  // empty: images
};

std::string processor() {
  std::ifstream stream("/proc/cpuinfo");
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

// Lengths in metres, as a chain's of its meshes; shares as plain numbers.
double tolerance_of(const Options& options, const fidelity::Front& front) {
  if (front.error_unit == "m" || front.subject == "chain")
    return text::parse_metres(options.tolerance);
  char* end = nullptr;
  const double share = std::strtod(options.tolerance.c_str(), &end);
  if (end == options.tolerance.c_str() || *end != '\0' || !(share > 0 && share < 1)) {
    throw geometry::InputError("'" + options.tolerance + "' is no share",
                               "Write a number between 0 and 1");
  }
  return share;
}

std::string error_text(const fidelity::Setting& setting, const fidelity::Front& front) {
  return front.error_unit == "m" ? fmt::format("{:.4g} mm", 1e3 * setting.error)
                                 : fmt::format("{:.3g} {}", setting.error, front.error_unit);
}

// As the launch files choose it, for the platform.
std::string front_of_chains(const Options& options) {
  const robot::Platform platform =
      robot::read_platform(robot::platform_file("config/robots", options.platform));
  return fidelity::chain_front_name(
      options.from == "cloud" ? fidelity::ChainInput::kCloud : fidelity::ChainInput::kImages,
      platform.hand.name, platform.name);
}

// `understand` refuses a setting that no longer fits the library.
int choose(const Options& options,
           const std::function<void(const fidelity::Setting&)>& understand) {
  const fidelity::Front front = fidelity::read_front(options.front);
  if (!options.from.empty() && !front.settings.empty() &&
      !begins_with(front.settings.front(), fidelity::chain_input(options.from))) {
    throw geometry::InputError(
        "'" + options.front.string() + "' is no front of chains from " + options.from,
        "Name one that is, or leave --from away");
  }
  const double budget = options.budget.empty() ? 0 : text::parse_seconds(options.budget);
  const double tolerance = options.tolerance.empty() ? 0 : tolerance_of(options, front);
  const fidelity::Setting& chosen =
      fidelity::choose_for_stage(front, budget, budget > 0 ? 0 : tolerance);
  // Both: the most accurate within the budget must also keep the tolerance.
  if (budget > 0 && tolerance > 0 && fidelity::tolerated_error(front, chosen) > tolerance) {
    throw fidelity::UnreachableError(
        "No setting keeps both " + options.budget + " and " + options.tolerance,
        "Within the budget " + error_text(chosen, front) + " can be reached", chosen);
  }
  understand(chosen);
  std::printf("%s\n%.4g ms, %s (%s; %s)\n", to_string(chosen).c_str(), 1e3 * chosen.seconds,
              error_text(chosen, front).c_str(), front.error_name.c_str(), front.machine.c_str());
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
                       1e3 * m.setting.error, m.failed, m.objects, to_string(m.setting));
  }
  std::vector<std::vector<std::string>> rows;
  for (const fidelity::Setting& s : front.settings) {
    best.points.emplace_back(1e3 * s.seconds, 1e3 * s.error);
    rows.push_back({fmt::format("{:.1f}", 1e3 * s.seconds), fmt::format("{:.2f}", 1e3 * s.error),
                    to_string(s)});
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
    stereo.push_back({to_string(m.setting), fmt::format("{:.0f}", 1e3 * m.setting.seconds),
                      fmt::format("{:.2f}", 1e3 * m.setting.error),
                      fmt::format("{} of {}", m.failed, m.objects)});
  }
  page.add_table({"method", "matching [ms]", "deviation of the default shape [mm]", "no mesh"},
                 stereo);
  eval::write_text(options.runs.out / "shape.csv", csv);
  eval::write_text(options.runs.out / "shape.svg", svg);
  page.write(options.runs.out / "index.html");
}

int sweep_shape(const Options& options) {
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
  const fs::path file = options.quick ? options.runs.out / "shape.yaml" : options.front;
  eval::make_folder(options.runs.out);
  fidelity::write_front(file, front);
  write_page(options, tradeoff, front);
  for (const fidelity::Setting& s : front.settings) {
    std::printf("%8.1f ms %6.2f mm  %s\n", 1e3 * s.seconds, 1e3 * s.error, to_string(s).c_str());
  }
  for (const eval::Measured& m : tradeoff.stereo) {
    std::printf("%8.0f ms %6.2f mm  %s\n", 1e3 * m.setting.seconds, 1e3 * m.setting.error,
                to_string(m.setting).c_str());
  }
  std::printf("%s\n%s\n", file.c_str(), (options.runs.out / "index.html").c_str());
  return EXIT_SUCCESS;
}

int sweep_plan(const Options& options) {
  const std::vector<eval::DataSet> sets = eval::data_sets_to_evaluate({});
  const std::vector<eval::Case> cases = eval::views_to_sweep(sets, options.quick);
  cv::setNumThreads(1);
  const auto measured = eval::measure_plan_tradeoff(cases, eval::swept_plan_settings(options.quick),
                                                    [](const std::string& text) {
                                                      std::printf("%s\n", text.c_str());
                                                      std::fflush(stdout);
                                                    });
  const fidelity::Front front = eval::plan_front(
      measured, fmt::format("{}, processor time, {} rendered views", processor(), cases.size()));
  report::LineChart chart{
      "Grasps of stage_pg70", "planning [ms]", "not lifted at the first attempt [%]", {}, {}};
  report::Series all{"settings", {}, {}, false}, best{"front", {}, {}, true};
  std::vector<std::vector<std::string>> rows;
  std::string csv = "milliseconds,first,within_three,views,knobs\n";
  for (const eval::MeasuredPlan& m : measured) {
    all.points.emplace_back(1e3 * m.setting.seconds, 100 * m.setting.error);
    rows.push_back({fmt::format("{:.0f}", 1e3 * m.setting.seconds), std::to_string(m.first),
                    std::to_string(m.within_three), to_string(m.setting)});
    csv += fmt::format("{:.1f},{},{},{},\"{}\"\n", 1e3 * m.setting.seconds, m.first, m.within_three,
                       m.views, to_string(m.setting));
  }
  for (const fidelity::Setting& s : front.settings) {
    best.points.emplace_back(1e3 * s.seconds, 100 * s.error);
  }
  chart.series = {all, best};
  report::Page page("Planning time against lifted objects");
  page.add_paragraph("Measured on: " + front.machine + ".");
  page.add_chart(report::draw_line_chart(chart),
                 "Every setting that was tried, and those that nothing beats");
  page.add_table({"planning [ms]", "lifted at first", "within three", "setting"}, rows);
  const fs::path file = options.quick ? options.runs.out / "plan.yaml" : options.front;
  eval::make_folder(options.runs.out);
  fidelity::write_front(file, front);
  eval::write_text(options.runs.out / "plan.csv", csv);
  page.write(options.runs.out / "index.html");
  std::printf("%s\n%s\n", file.c_str(), (options.runs.out / "index.html").c_str());
  return EXIT_SUCCESS;
}

int sweep_touch(const Options& options) {
  const eval::touch::TouchTradeoff tradeoff = eval::touch::measure_touch_tradeoff(
      eval::touch::touch_sweep(options.quick), [](const std::string& text) {
        std::printf("%s\n", text.c_str());
        std::fflush(stdout);
      });
  // A quick look is no measurement to choose from later.
  const fs::path fronts = options.quick ? options.runs.out : options.front.parent_path();
  eval::make_folder(options.runs.out);
  eval::touch::write_touch_tradeoff(tradeoff, processor() + ", processor time", fronts,
                                    options.runs.out);
  std::printf("%s\n%s\n", fronts.c_str(), (options.runs.out / "index.html").c_str());
  return EXIT_SUCCESS;
}

int sweep_chain(const Options& options) {
  eval::ChainSweep sweep;
  sweep.input = fidelity::chain_input(options.from.empty() ? "images" : options.from);
  sweep.platform = robot::platform_file(text::tree_file("config/robots"), options.platform);
  sweep.runs = options.runs;
  sweep.front = options.front;
  sweep.machine = processor();
  sweep.quick = options.quick;
  return eval::sweep_chains(sweep);
}

struct Subject {
  const char* name;
  const char* what;
  const char* example_budget;
  const char* example_tolerance;
  int (*sweep)(const Options&);
  void (*understand)(const fidelity::Setting&);
};

constexpr Subject kSubjects[] = {
    {"shape", "from segmented cloud to mesh", "60ms", "3mm", sweep_shape,
     [](const fidelity::Setting& setting) { (void)fidelity::shape_options(setting); }},
    {"plan", "grasps of stage_pg70 on a predicted mesh; the error is a share of views", "200ms",
     "0.1", sweep_plan,
     [](const fidelity::Setting& setting) {
       grasp::PlannerOptions planner;
       fidelity::apply_plan_setting(setting, &planner);
     }},
    {"chain",
     "from a stereo pair, or its cloud, to ranked grasps with the arm's motions, and the lift; "
     "times are of one processor, the error is a share of views, --tolerance of the meshes",
     "300ms", "3mm", sweep_chain,
     [](const fidelity::Setting& setting) {
       fidelity::Front chain;
       chain.subject = "chain";
       fidelity::SeeingOptions seeing;
       grasp::PlannerOptions planner;
       fidelity::apply_first_stage(chain, setting, &seeing);
       (void)fidelity::shape_options(stage_setting(chain, setting, fidelity::Stage::kShape));
       fidelity::apply_plan_setting(stage_setting(chain, setting, fidelity::Stage::kPlan),
                                    &planner);
     }},
    {"touch",
     "what soft pads feel; times are of each simulated second, the error is a share of the largest "
     "sum of a pad",
     "2ms", "0.01", sweep_touch, [](const fidelity::Setting& setting) {
       simulation::Scene scene;
       fidelity::apply_touch_setting(setting, &scene);
     }}};

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Speed against accuracy where the truth is known.");
  app.require_subcommand(1);
  for (const Subject& subject : kSubjects) {
    CLI::App* command = app.add_subcommand(
        subject.name, std::string(subject.what) +
                          ": sweeps the knobs and writes the front; with --budget or --tolerance "
                          "chooses from the front that was written");
    command->add_option("--out", options.runs.out, "folder of the page")->capture_default_str();
    command->add_option(
        "--front", options.front,
        std::string("file of the front (config/fidelity/") + subject.name + ".yaml)");
    command->add_option(
        "--budget", options.budget,
        std::string("choose the most accurate within a time, e.g. ") + subject.example_budget);
    command->add_option(
        "--tolerance", options.tolerance,
        std::string("choose the fastest within an error, e.g. ") + subject.example_tolerance);
    command->add_flag("--quick", options.quick, "few settings; leaves the front alone");
    if (subject.sweep != sweep_chain) continue;
    command
        ->add_option("--from", options.from,
                     "images or cloud: what the chains begin with, and the front where none is "
                     "named (chain_cloud.yaml; chain_hand.yaml and chain_cloud_hand.yaml of other "
                     "platforms than stage_pg70). Default: images")
        ->check(CLI::IsMember({"images", "cloud"}));
    command->add_option("--platform", options.platform, "name or file of config/robots")
        ->capture_default_str();
    eval::add_run_options(*command, options.runs);
  }
  if (const auto code = text::parse_command_line(app, argc, argv)) return *code;
  try {
    for (const Subject& subject : kSubjects) {
      if (!app.got_subcommand(subject.name)) continue;
      if (options.front.empty()) {
        options.front = "config/fidelity/" + (subject.sweep == sweep_chain
                                                  ? front_of_chains(options)
                                                  : std::string(subject.name) + ".yaml");
      }
      const bool choosing = !options.budget.empty() || !options.tolerance.empty();
      return choosing ? choose(options, subject.understand) : subject.sweep(options);
    }
    return EXIT_FAILURE;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
}
