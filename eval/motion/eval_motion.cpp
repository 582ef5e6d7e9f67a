// MotionBenchMaker's problems, or others of its form, by planners of prehend and OMPL.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "eval/case_choice.h"
#include "eval/motion/motion_trial.h"
#include "eval/text_files.h"
#include "prehend/geometry/errors.h"
#include "prehend/motion/planner_registry.h"
#include "prehend/text/command_line.h"
#include "prehend/text/json.h"

namespace {

using namespace prehend;
using eval::MotionResult;

struct Options {
  std::string urdf, srdf, problems, json;
  std::vector<std::string> planners{"rrt_connect", "ompl_rrt_connect"}, only;
  eval::MotionTrialOptions trial;
  int every = 1;
};

double share_at(std::vector<double> values, double share) {
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double one : values) sum += one;
  return values.empty() ? NAN : sum / static_cast<double>(values.size());
}

void print_row(const std::string& name, const std::vector<const MotionResult*>& results) {
  std::vector<double> times, lengths, set_ups;
  int solved = 0, valid = 0;
  for (const MotionResult* one : results) {
    set_ups.push_back(one->set_up);
    if (!one->solved) continue;
    ++solved;
    valid += one->invalid.empty() ? 1 : 0;
    times.push_back(1e6 * one->time);
    lengths.push_back(one->length);
  }
  fmt::print("  {:24} {:4} of {:4} {:6} {:9.0f} {:9.0f} {:9.0f} {:9.0f} {:8.2f} {:9.0f}\n", name,
             solved, results.size(), valid, share_at(times, 0.5), mean(times),
             share_at(times, 0.95), share_at(times, 1), share_at(lengths, 0.5),
             1e6 * share_at(set_ups, 0.5));
}

void print_results(const std::vector<MotionResult>& results) {
  std::map<std::string, std::map<std::string, std::vector<const MotionResult*>>> by_planner;
  for (const MotionResult& one : results) {
    by_planner[one.planner][one.set].push_back(&one);
    by_planner[one.planner]["~all"].push_back(&one);
  }
  for (const auto& [planner, sets] : by_planner) {
    fmt::print("\n{}\n  {:24} {:>12} {:>6} {:>9} {:>9} {:>9} {:>9} {:>8} {:>9}\n", planner, "",
               "solved", "valid", "median us", "mean", "95 %", "worst", "length", "set up us");
    for (const auto& [set, of_set] : sets) print_row(set == "~all" ? "all" : set, of_set);
  }
  for (const MotionResult& one : results) {
    if (!one.solved) fmt::print("{} {} {}: {}\n", one.planner, one.set, one.name, one.reason);
    if (!one.invalid.empty()) {
      fmt::print("{} {} {}: not valid: {}\n", one.planner, one.set, one.name, one.invalid);
    }
  }
}

text::Json json_of(const MotionResult& one) {
  text::Json json = text::Json::object();
  json.set("planner", one.planner).set("set", one.set).set("problem", one.name);
  json.set("solved", one.solved).set("reason", one.reason).set("invalid", one.invalid);
  json.set("set_up_s", one.set_up).set("time_s", one.time).set("length_rad", one.length);
  return json.set("iterations", one.iterations);
}

int run(const Options& options) {
  std::vector<eval::MotionProblem> problems = eval::read_motion_problems(options.problems);
  std::vector<std::string> sets;
  for (const eval::MotionProblem& one : problems) {
    if (sets.empty() || sets.back() != one.set) sets.push_back(one.set);
  }
  eval::check_only(options.only, sets, "set of problems");
  std::erase_if(problems, [&](const eval::MotionProblem& one) {
    return !options.only.empty() && std::ranges::find(options.only, one.set) == options.only.end();
  });
  const motion::PlannerRegistry registry;
  std::vector<std::unique_ptr<motion::PathPlanner>> planners;
  for (const std::string& name : options.planners) planners.push_back(registry.create(name));
  const auto robot = eval::with_fixed(
      eval::read_planning_robot(options.urdf, options.srdf, problems.front().group),
      problems.front().start);
  fmt::print(stderr, "{} problems; the robot is covered by balls\n", problems.size());
  eval::MotionTrials trials(robot, options.trial);
  std::vector<MotionResult> results;
  int tried = 0, invalid = 0;
  for (std::size_t i = 0; i < problems.size(); i += static_cast<std::size_t>(options.every)) {
    ++tried;
    const std::string what = trials.invalid_problem(problems[i]);
    if (!what.empty()) {
      ++invalid;
      fmt::print("{} {}: the problem itself is not valid: {}\n", problems[i].set, problems[i].name,
                 what);
      continue;
    }
    for (const auto& planner : planners) results.push_back(trials.run(problems[i], *planner));
    fmt::print(stderr, "\r{} of {} problems", i + 1, problems.size());
  }
  fmt::print(stderr, "\n");
  fmt::print("{} of {} problems, of which {} are not valid\n", tried, problems.size(), invalid);
  print_results(results);
  if (!options.json.empty()) {
    text::Json all = text::Json::array();
    for (const MotionResult& one : results) all.add(json_of(one));
    eval::write_text(options.json, all.pretty());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Plans motions for the problems of a folder as MotionBenchMaker writes them, and sweeps each "
      "path against the robot's own meshes",
      "eval_motion");
  app.add_option("--urdf", options.urdf, "the robot")->required()->check(CLI::ExistingFile);
  app.add_option("--srdf", options.srdf, "its groups and the links that may touch")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("problems", options.problems, "folder of SET/sceneN.yaml and SET/requestN.yaml")
      ->required()
      ->check(CLI::ExistingDirectory);
  app.add_option("--planner", options.planners, "planners by name")->capture_default_str();
  app.add_option("--only", options.only, "these sets");
  app.add_option("--every", options.every, "every n-th problem")->check(text::above_zero());
  app.add_option(
         "--balls", options.trial.ball_resolutions,
         "m, how finely balls cover the robot, a fifth of it beyond meshes; the next where one "
         "leads to no path")
      ->capture_default_str();
  app.add_option("--checkers", options.trial.checkers,
                 "collision checkers that test the links' own shapes, each where those before it, "
                 "balls first, led to no path; none: balls alone")
      ->expected(0, -1)
      ->capture_default_str();
  app.add_option("--resolution", options.trial.path.resolution,
                 "rad or m, of a search that does not sweep")
      ->check(text::above_zero())
      ->capture_default_str();
  app.add_option("--step", options.trial.path.step, "rad or m, of a branch")
      ->check(text::above_zero())
      ->capture_default_str();
  app.add_option("--iterations", options.trial.path.iterations, "samples at most")
      ->capture_default_str();
  app.add_option("--shortcuts", options.trial.path.shortcuts, "at most")->capture_default_str();
  app.add_option("--check-step", options.trial.check_step, "rad or m, of the sweep")
      ->check(text::above_zero())
      ->capture_default_str();
  app.add_option("--seed", options.trial.path.seed)->capture_default_str();
  app.add_option("--json", options.json, "file for the results");
  return eval::parse_and_run(app, argc, argv, [&] { return run(options); });
}
