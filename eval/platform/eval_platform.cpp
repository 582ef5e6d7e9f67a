// What a user runs, measured: camera -> nodes -> arm -> hand, by the launch file, on generated
// scenes.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "eval/case_choice.h"
#include "eval/platform/launched.h"
#include "eval/platform/pick_run.h"
#include "eval/text_files.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/command_line.h"
#include "prehend/text/tree_file.h"

namespace {

using namespace prehend;
using Outcome = eval::PickResult::Outcome;
namespace fs = std::filesystem;

struct Options {
  eval::CaseChoice choice = eval::default_choice("out/platform");
  std::vector<std::string> platforms{"stage_pg70"};
  int scenes = 60;
  std::vector<std::string> arguments;  // of the launch file
};

struct Run {
  const eval::TableScene* scene;
  std::string platform;
  std::string name() const { return platform + "_" + scene->name; }
};

std::string csv_of(const std::vector<eval::PickResult>& results) {
  std::string text =
      "platform,scene,bodies,outcome,body,raised_m,carried_m,disturbed_m,attempts,score,seconds,"
      "stage,reason\n";
  for (const eval::PickResult& r : results) {
    std::string reason = r.reason;
    std::replace(reason.begin(), reason.end(), '"', '\'');
    text += fmt::format("{},{},{},{},{},{:.4f},{:.4f},{:.4f},{},{:.3f},{:.1f},{},\"{}\"\n",
                        r.platform, r.scene, r.bodies, to_string(r.outcome), r.body, r.raised,
                        r.carried, r.disturbed, r.attempts, r.score, r.seconds, r.stage, reason);
  }
  return text;
}

std::string summary_of(const std::vector<std::string>& platforms,
                       const std::vector<eval::PickResult>& results) {
  std::string text = fmt::format("\n{:<14} {:>6} {:>18} {:>12} {:>8} {:>12} {:>9} {:>9}\n",
                                 "platform", "scenes", "picked of graspable", "first try", "failed",
                                 "false claim", "no grasp", "s a run");
  for (const std::string& platform : platforms) {
    std::map<Outcome, int> counts;
    int all = 0, first = 0;
    double seconds = 0;
    for (const eval::PickResult& r : results) {
      if (r.platform != platform) continue;
      ++all;
      ++counts[r.outcome];
      seconds += r.seconds;
      first += r.outcome == Outcome::kPicked && r.attempts == 1 ? 1 : 0;
    }
    const int tried = all - counts[Outcome::kNoGrasp];
    text += fmt::format("{:<14} {:>6} {:>18} {:>12} {:>8} {:>12} {:>9} {:>9.1f}\n", platform, all,
                        fmt::format("{} of {} ({:.0f} %)", counts[Outcome::kPicked], tried,
                                    100.0 * counts[Outcome::kPicked] / std::max(1, tried)),
                        first, counts[Outcome::kFailed], counts[Outcome::kFalseClaim],
                        counts[Outcome::kNoGrasp], seconds / std::max(1, all));
  }
  for (const eval::PickResult& r : results) {
    if (r.outcome == Outcome::kPicked) continue;
    text += fmt::format("{} {}: {} in {}: {}\n", r.platform, r.scene, to_string(r.outcome), r.stage,
                        r.reason);
  }
  return text;
}

int run(const Options& options) {
  eval::check_platforms(options.platforms);
  const std::vector<eval::DataSet> sets = eval::chosen_data_sets(options.choice);
  const auto scenes = eval::of_each_seed(options.choice, [&](std::uint64_t seed) {
    return eval::make_table_scenes(sets, options.scenes, seed);
  });
  std::vector<Run> runs;
  for (const std::string& platform : options.platforms) {
    for (const eval::TableScene& scene : scenes) runs.push_back({&scene, platform});
  }
  if (options.choice.list) {
    for (const Run& one : runs) {
      std::string bodies;
      for (const auto& body : one.scene->bodies) bodies += " " + body.name;
      std::printf("%s:%s\n", one.name().c_str(), bodies.c_str());
    }
    return EXIT_SUCCESS;
  }
  const std::vector<std::string> arguments = eval::launch_arguments(options.arguments);
  const fs::path programs = fs::read_symlink("/proc/self/exe").parent_path();
  eval::CaseRunOptions where = options.choice.runs;
  for (const std::string& argument : arguments) where.setting += argument + "\n";
  std::vector<std::string> names;
  for (const Run& one : runs) names.push_back(one.name());
  const auto results =
      eval::found_results(eval::run_cases(where, names, eval::read_pick, [&](int i) {
        const Run& one = runs[static_cast<std::size_t>(i)];
        const fs::path folder = options.choice.runs.out / "runs" / one.name();
        return eval::run_pick(*one.scene, one.platform, arguments, folder, programs);
      }));
  eval::write_text(options.choice.runs.out / "cases.csv", csv_of(results));
  std::printf("%s", summary_of(options.platforms, results).c_str());
  std::printf("\n%s\n", (options.choice.runs.out / "cases.csv").c_str());
  return results.size() == runs.size() ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  options.choice.runs.processes = 1;
  CLI::App app(
      "Launches the demo on generated scenes of one to four bodies, with each platform, as fast as "
      "it can, and judges by the simulation's truth: raised by 5 cm, carried, put down, nothing "
      "else "
      "moved by more than 2 cm. Recordings and reports lie below runs/ in the folder --out. A run "
      "that was interrupted goes on where it was.");
  eval::add_case_options(app, options.choice, false);
  const std::vector<std::string> known = robot::platform_names(text::tree_file("config/robots"));
  app.add_option("--platform", options.platforms, "the robots, one or more")
      ->check(CLI::IsMember(known))
      ->capture_default_str();
  app.add_option("--scenes", options.scenes, "how many scenes are generated")
      ->check(text::in_range(1, 100000))
      ->capture_default_str();
  app.add_option("--launch-argument", options.arguments,
                 "of launch/demo.yaml, for all runs, e.g. minimum_stability:=0.1; results with "
                 "others are forgotten")
      ->type_name("NAME:=VALUE");
  return eval::parse_and_run(app, argc, argv, [&options] { return run(options); });
}
