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
#include <CLI/CLI.hpp>

#include "eval/case_choice.h"
#include "eval/case_runs.h"
#include "eval/grasp/stability_report.h"
#include "eval/grasp/stability_trials.h"
#include "eval/text_files.h"
#include "prehend/robot/robot_files.h"

namespace {

using namespace prehend;
namespace fs = std::filesystem;

constexpr int kGrasps = 1000, kQuickGrasps = 90;

struct Options {
  fs::path out = "out/grasp_stability";
  fs::path json, fit, meshes;
  std::vector<std::string> groups;
  std::vector<std::string> platforms{"pa10_barrett", "kr5_sdh", "stage_pg70"};
  fs::path robots = "config/robots";
  int grasps = 0;
  std::uint64_t seed = 1;
  bool quick = false;
};

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
  trials.grasps = options.grasps > 0 ? options.grasps : (options.quick ? kQuickGrasps : kGrasps);
  trials.seed = options.seed;
  const auto all = eval::run_stability_trials(platforms, objects, trials, [](const auto& said) {
    std::fprintf(stderr, "%s\n", said.c_str());
  });
  std::string command = "build/bin/eval_grasp_stability";
  if (options.quick) command += " --quick";
  if (options.grasps > 0) command += fmt::format(" --grasps {}", options.grasps);
  if (options.seed != 1) command += fmt::format(" --seed {}", options.seed);
  const eval::StabilityFindings findings = eval::stability_findings(all);
  std::printf("%s", eval::stability_text(findings).c_str());
  if (!options.json.empty()) eval::write_text(options.json, eval::stability_json(findings));
  eval::write_stability_report(options.out, findings, all);
  std::printf("\n%s\n", (options.out / "index.html").c_str());
  if (!options.fit.empty()) {
    eval::fitted_stability(all).save(options.fit,
                                     "Made by " + command +
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
  app.add_option(
         "--grasps", options.grasps,
         fmt::format("that close on something, of all platforms together (default {})", kGrasps))
      ->check(CLI::Range(6, 1000000));
  app.add_option("--seed", options.seed, "of how grasps are spoilt and of the pads' electronics")
      ->capture_default_str();
  app.add_flag("--quick", options.quick,
               fmt::format("{} grasps of every third object, for a first look", kQuickGrasps));
  return eval::parse_and_run(app, argc, argv, [&options] { return run(options); });
}
