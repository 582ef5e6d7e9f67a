// Clutter, cleared: the launch file's whole chain on tables of things that touch, lie on, lean on
// and hide one another.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "eval/case_choice.h"
#include "eval/platform/clear_run.h"
#include "eval/platform/clutter_cases.h"
#include "eval/platform/graspable_bodies.h"
#include "eval/platform/launched.h"
#include "eval/text_files.h"
#include "prehend/report/page.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/command_line.h"
#include "prehend/text/tree_file.h"

namespace {

using namespace prehend;
using eval::ClearResult;
namespace fs = std::filesystem;

struct Options {
  eval::CaseChoice choice = eval::default_choice("out/scene");
  std::vector<std::string> platforms{"stage_pg70"};
  int scenes = 28;
  double widest = 0.06;                // m
  std::vector<std::string> arguments;  // of the launch file
};

struct Run {
  const eval::ClutterCase* scene;
  std::string platform;
  std::string name() const { return platform + "_" + scene->name; }
};

std::string share(int some, int all) {
  return fmt::format("{} of {} ({:.0f} %)", some, all, 100.0 * some / std::max(1, all));
}

// Sums over runs.
struct Sum {
  int scenes = 0, ended = 0, bodies = 0, found = 0, cleared = 0, attempts = 0, pushes = 0;
  int neighbours = 0;
  int graspable = 0, graspable_cleared = 0;
  double simulated = 0, seconds = 0;  // s
  std::map<std::string, int> failures;

  void add(const ClearResult& r) {
    ++scenes;
    ended += r.ended ? 1 : 0;
    bodies += r.bodies;
    found += std::min(r.found, r.bodies);
    cleared += r.cleared;
    graspable += static_cast<int>(r.graspable.size());
    graspable_cleared += r.graspable_cleared();
    attempts += r.attempts;
    pushes += r.pushes;
    neighbours += r.neighbours;
    simulated += r.simulated;
    seconds += r.seconds;
    for (const auto& [cause, count] : r.failures) failures[cause] += count;
  }
  std::vector<std::string> row(const std::string& platform, const std::string& kind) const {
    std::string causes;
    for (const auto& [cause, count] : failures) {
      causes += fmt::format("{}{} {}", causes.empty() ? "" : ", ", cause, count);
    }
    return {platform,
            kind,
            fmt::format("{}", scenes),
            share(cleared, bodies),
            share(graspable_cleared, graspable),
            fmt::format("{}", found),
            cleared > 0 ? fmt::format("{:.2f}", 1.0 * attempts / cleared) : "-",
            fmt::format("{}", pushes),
            simulated > 0 ? fmt::format("{:.0f}", 3600 * cleared / simulated) : "-",
            causes.empty() ? "-" : causes,
            fmt::format("{}", neighbours),
            fmt::format("{}", scenes - ended),
            fmt::format("{:.1f}", seconds / std::max(1, scenes))};
  }
};

const std::vector<std::string> kHeader{"platform",         "kind",
                                       "scenes",           "cleared",
                                       "of the graspable", "seen in the first look",
                                       "attempts each",    "pushes",
                                       "an hour",          "failed attempts",
                                       "neighbours moved", "without an end",
                                       "s a scene"};

std::vector<std::vector<std::string>> rows_of(const std::vector<std::string>& platforms,
                                              const std::vector<ClearResult>& results) {
  std::vector<std::vector<std::string>> rows;
  for (const std::string& platform : platforms) {
    std::map<std::string, Sum> kinds;
    Sum all;
    for (const ClearResult& r : results) {
      if (r.platform != platform) continue;
      kinds[r.kind].add(r);
      all.add(r);
    }
    for (const auto& [kind, sum] : kinds) rows.push_back(sum.row(platform, kind));
    rows.push_back(all.row(platform, "all"));
  }
  return rows;
}

std::string csv_of(const std::vector<ClearResult>& results) {
  std::string text =
      "platform,scene,kind,bodies,graspable,found,cleared,graspable_cleared,attempts,pushes,"
      "neighbours,"
      "simulated_s,seconds,ended,"
      "left,reason\n";
  for (const ClearResult& r : results) {
    std::string reason = r.reason;
    std::replace(reason.begin(), reason.end(), '"', '\'');
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{:.1f},{:.1f},{},{},\"{}\"\n", r.platform,
                        r.scene, r.kind, r.bodies, r.graspable.size(), r.found, r.cleared,
                        r.graspable_cleared(), r.attempts, r.pushes, r.neighbours, r.simulated,
                        r.seconds, r.ended ? 1 : 0, fmt::join(r.left, " "), reason);
  }
  return text;
}

void write_page(const fs::path& folder, const std::vector<std::vector<std::string>>& rows,
                const std::vector<ClearResult>& results) {
  report::Page page("Clutter, cleared");
  page.add_table(kHeader, rows);
  page.add_heading("Scenes");
  std::vector<std::vector<std::string>> scenes;
  for (const ClearResult& r : results) {
    scenes.push_back({r.platform, r.scene, fmt::format("{} of {}", r.cleared, r.bodies),
                      fmt::format("{}", r.attempts), fmt::format("{}", r.pushes),
                      fmt::format("{}", fmt::join(r.left, " ")), r.reason});
  }
  page.add_table({"platform", "scene", "cleared", "attempts", "pushes", "left", "how it ended"},
                 scenes);
  std::map<std::string, int> said;
  for (const ClearResult& r : results) {
    for (const auto& [words, count] : r.said) said[words] += count;
  }
  page.add_heading("Attempts that failed, in the cycle's words");
  std::vector<std::vector<std::string>> failures;
  for (const auto& [words, count] : said) {
    failures.push_back({fmt::format("{}", count), eval::cause_of(words), words});
  }
  page.add_table({"times", "cause", "words"}, failures);
  page.write(folder / "index.html");
}

// Makes the scene, and plays the task in it.
ClearResult result_of(const Run& one, const std::vector<simulation::ClutterSolid>& solids,
                      const std::vector<std::string>& arguments, const fs::path& folder,
                      const fs::path& programs) {
  eval::make_folder(folder);
  const eval::ClutterCase& clutter = *one.scene;
  const fs::path file = folder / (clutter.name + ".yaml");
  const auto bodies = simulation::drop_clutter(solids, clutter.options);
  const auto scene =
      simulation::clutter_scene(solids, bodies, folder, clutter.varied, clutter.options.seed);
  simulation::write_clutter(file, solids, bodies, simulation::clutter_truth(solids, bodies, scene),
                            scene);
  ClearResult result = eval::run_clear(file, one.platform, arguments, folder, programs);
  result.kind = clutter.kind;
  const fs::path robots = text::tree_file("config/robots");
  result.graspable = eval::graspable_bodies(
      solids, bodies, robot::read_platform(robot::platform_file(robots, one.platform)));
  return result;
}

int run(const Options& options) {
  eval::check_platforms(options.platforms);
  const std::vector<eval::DataSet> sets = eval::chosen_data_sets(options.choice);
  const auto cases = eval::of_each_seed(options.choice, [&](std::uint64_t seed) {
    return eval::clutter_cases(options.scenes, seed);
  });
  std::vector<Run> runs;
  for (const std::string& platform : options.platforms) {
    for (const eval::ClutterCase& one : cases) runs.push_back({&one, platform});
  }
  if (options.choice.list) {
    for (const Run& one : runs) {
      std::printf("%s: %d bodies\n", one.name().c_str(), one.scene->options.count);
    }
    return EXIT_SUCCESS;
  }
  const auto solids = eval::clutter_solids(sets, options.widest);
  const std::vector<std::string> arguments = eval::launch_arguments(options.arguments);
  const fs::path programs = fs::read_symlink("/proc/self/exe").parent_path();
  eval::CaseRunOptions where = options.choice.runs;
  where.setting = fmt::format("widest {}\n", options.widest);
  for (const simulation::ClutterSolid& solid : solids) where.setting += solid.name + "\n";
  for (const std::string& argument : arguments) where.setting += argument + "\n";
  std::vector<std::string> names;
  for (const Run& one : runs) names.push_back(one.name());
  const auto results =
      eval::found_results(eval::run_cases(where, names, eval::read_clear, [&](int i) {
        const Run& one = runs[static_cast<std::size_t>(i)];
        const fs::path folder = options.choice.runs.out / "runs" / one.name();
        return result_of(one, solids, arguments, folder, programs);
      }));
  const auto rows = rows_of(options.platforms, results);
  eval::write_text(options.choice.runs.out / "cases.csv", csv_of(results));
  write_page(options.choice.runs.out, rows, results);
  std::printf("\n%s\n", fmt::format("{}", fmt::join(kHeader, " | ")).c_str());
  for (const auto& row : rows) {
    std::printf("%s\n", fmt::format("{}", fmt::join(row, " | ")).c_str());
  }
  std::printf("\n%s\n", (options.choice.runs.out / "index.html").c_str());
  return results.size() == runs.size() ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  options.choice.runs.processes = 1;
  CLI::App app(
      "Clears tables: things of the chosen groups are dropped until they rest, apart, touching, "
      "stacked, leaning, hidden and tumbled, 1 to 12 of them, and the launch file's task "
      "clear_table is run on each as fast as it can. Judged by the simulation's truth: what stands "
      "where the task puts things is cleared; graspable is what could be grasped if its shape were "
      "known and it lay there alone. Scenes, recordings and reports lie below runs/ in "
      "the folder --out. A run that was interrupted goes on where it was.");
  eval::add_case_options(app, options.choice, false);
  const std::vector<std::string> known = robot::platform_names(text::tree_file("config/robots"));
  app.add_option("--platform", options.platforms, "the robots, one or more")
      ->check(CLI::IsMember(known))
      ->capture_default_str();
  app.add_option("--scenes", options.scenes, "how many scenes are made")
      ->check(text::in_range(1, 100000))
      ->capture_default_str();
  app.add_option("--widest", options.widest,
                 "bodies that are wider across every horizontal direction are left out [m]; 0.06 "
                 "leaves 9 mm to the PG70")
      ->check(text::in_range(0.01, 1.0))
      ->capture_default_str();
  app.add_option("--launch-argument", options.arguments,
                 "of launch/demo.yaml, for all runs, e.g. minimum_stability:=0.1; results with "
                 "others are forgotten")
      ->type_name("NAME:=VALUE");
  return eval::parse_and_run(app, argc, argv, [&options] { return run(options); });
}
