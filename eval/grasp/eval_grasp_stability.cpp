// Whether a lift will hold, told by what the hand's pads feel alone: learned on some objects, asked
// about others.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "eval/case_choice.h"
#include "eval/case_runs.h"
#include "eval/grasp/stability_report.h"
#include "eval/grasp/stability_trials.h"
#include "eval/text_files.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/command_line.h"

namespace {

using namespace prehend;
namespace fs = std::filesystem;

// A grasp of the PG70 takes a quarter of the time that one of fingers takes.
const std::vector<int> kGrasps{640, 280, 100}, kQuickGrasps{60, 20, 10};

struct Options {
  fs::path out = "out/grasp_stability";
  fs::path json, fit, meshes;
  std::vector<std::string> groups;
  std::vector<std::string> platforms{"stage_pg70", "kr5_sdh", "pa10_barrett"};
  fs::path robots = "config/robots";
  std::vector<int> grasps;
  std::uint64_t seed = 1;
  bool quick = false;
};

// That gives the same again.
std::string command_of(const Options& options) {
  std::string command = "build/bin/eval_grasp_stability";
  if (options.quick) command += " --quick";
  if (options.platforms != Options().platforms) {
    command += fmt::format(" --platform {}", fmt::join(options.platforms, " "));
  }
  if (!options.groups.empty()) {
    command += fmt::format(" --groups {}", fmt::join(options.groups, " "));
  }
  if (!options.meshes.empty()) command += " --meshes " + options.meshes.string();
  if (!options.grasps.empty()) {
    command += fmt::format(" --grasps {}", fmt::join(options.grasps, " "));
  }
  if (options.seed != 1) command += fmt::format(" --seed {}", options.seed);
  return command;
}

int run(const Options& options) {
  std::vector<fs::path> platforms;
  for (const std::string& name : options.platforms) {
    platforms.push_back(robot::platform_file(options.robots, name));
  }
  std::vector<eval::DataSet> objects = eval::data_sets_to_evaluate(options.meshes, options.groups);
  if (options.quick) {  // every third
    std::vector<eval::DataSet> some;
    for (std::size_t i = 0; i < objects.size(); i += 3) some.push_back(objects[i]);
    objects = std::move(some);
  }
  eval::StabilityTrialOptions trials;
  trials.grasps = options.grasps;
  if (trials.grasps.empty()) trials.grasps = options.quick ? kQuickGrasps : kGrasps;
  const bool one_for_all = options.grasps.empty() || options.grasps.size() == 1;
  if (one_for_all) trials.grasps.resize(platforms.size(), trials.grasps.back());
  if (trials.grasps.size() != platforms.size()) {
    throw geometry::InputError(fmt::format("--grasps has {} numbers for {} platforms",
                                           trials.grasps.size(), platforms.size()),
                               "Write one for all, or one for each platform");
  }
  trials.seed = options.seed;
  const auto all = eval::run_stability_trials(platforms, objects, trials, [](const auto& said) {
    std::fprintf(stderr, "%s\n", said.c_str());
  });
  const eval::StabilityFindings findings = eval::stability_findings(all);
  std::printf("%s", eval::stability_text(findings).c_str());
  if (!options.json.empty()) eval::write_text(options.json, eval::stability_json(findings));
  eval::write_stability_report(options.out, findings, all);
  std::printf("\n%s\n", (options.out / "index.html").c_str());
  if (!options.fit.empty()) {
    eval::fitted_stability(all).save(options.fit,
                                     "Made by " + command_of(options) +
                                         " --fit FILE; there measured on objects that were not "
                                         "learned:\n" +
                                         eval::stability_text(findings));
    std::printf("%s\n", options.fit.c_str());
  }
  return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Grasps known bodies in simulation with the cycle that runs on the robot: as planned, "
      "beside, "
      "turned, too high, weakly, heavier than they look, slippery. Asks when the hand has closed, "
      "and again when it has risen by 10 mm, by what the pads feel alone, whether the lift holds; "
      "then lifts. Learned on nine tenths of the objects, asked about the others. 12 household "
      "objects made by code (with PREHEND_SHARED_DATA scanned ones as well), some also lying; "
      "every "
      "second grasp is felt by realistic pads. The same seed gives the same figures.");
  app.add_option("--out", options.out, "folder of the report: index.html, trials.csv")
      ->capture_default_str();
  app.add_option("--json", options.json, "file of the figures");
  app.add_option("--fit", options.fit,
                 "writes the model learned on all objects: config/touch/grasp_stability.yaml");
  app.add_option("--platform", options.platforms,
                 "arms with hands that have pads, one or more: what is in --robots, or a file")
      ->capture_default_str();
  app.add_option("--robots", options.robots, "folder of the platforms' files")
      ->check(CLI::ExistingDirectory)
      ->capture_default_str();
  app.add_option("--groups", options.groups, "of objects; default: household and scanned");
  app.add_option("--meshes", options.meshes, "folder of meshes to grasp in place of them")
      ->check(CLI::ExistingDirectory);
  app.add_option("--grasps", options.grasps,
                 fmt::format("that close on something, of each platform (default {}); one number: "
                             "of each as many",
                             fmt::join(kGrasps, " ")))
      ->check(text::in_range(1, 1000000));
  app.add_option("--seed", options.seed, "of how grasps are spoilt and of the pads' electronics")
      ->capture_default_str();
  app.add_flag("--quick", options.quick,
               fmt::format("{} grasps of every third object, for a first look",
                           fmt::join(kQuickGrasps, " and ")));
  return eval::parse_and_run(app, argc, argv, [&options] { return run(options); });
}
