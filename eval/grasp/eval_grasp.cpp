// Grasps planned on predicted shapes, executed in simulation on the true ones.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "eval/case_choice.h"
#include "eval/grasp/grasp_report.h"
#include "eval/grasp/grasp_trials.h"
#include "eval/grasp/platform_under_test.h"
#include "eval/text_files.h"
#include "prehend/control/task.h"
#include "prehend/fidelity/chosen_chain.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/command_line.h"
#include "prehend/text/tree_file.h"

namespace {

using namespace prehend;
namespace fs = std::filesystem;

// What of the evidence of failed attempts is used.
const std::vector<std::pair<std::string, belief::EvidenceUse>> kEvidence{
    {"none", belief::EvidenceUse::kNone},
    {"contacts", belief::EvidenceUse::kContacts},
    {"empty_space", belief::EvidenceUse::kEmptySpace},
    {"looks", belief::EvidenceUse::kLooks}};

std::vector<std::string> names_of_planned_on() {
  std::vector<std::string> names;
  for (const eval::PlannedOn on : eval::kPlannedOn) names.emplace_back(to_string(on));
  return names;
}

struct Options {
  eval::CaseChoice choice = eval::default_choice("out/grasp");
  std::vector<std::string> platforms{"stage_pg70"};
  std::vector<std::string> planned_on = names_of_planned_on();
  double budget = 0, tolerance = 0;  // s, m; 0: the defaults
  std::string from;                  // what the chain that these choose begins with
  bool open_loop = false;
  std::string evidence = kEvidence.back().first;
  std::string task = "pick_and_place";
  fs::path robots = "config/robots";
};

struct PlatformCase {
  eval::Case one;
  const eval::PlatformUnderTest* platform;
  const eval::ChainOptions* chain;
};

// Whether it is of every setting.
bool is_complete(const eval::GraspCase& result, const std::vector<eval::PlannerSetting>& settings) {
  return std::all_of(settings.begin(), settings.end(), [&](const auto& setting) {
    const eval::GraspTrial* trial = result.trial(setting.name);
    return trial != nullptr && trial->is_planned_only == !setting.is_executed;
  });
}

int run(const Options& options) {
  eval::check_platforms(options.platforms);
  std::deque<eval::PlatformUnderTest> platforms;
  std::deque<eval::ChainOptions> chains;
  eval::CaseRunOptions runs = options.choice.runs;
  const eval::ExecutionChoice choice{
      !options.open_loop,
      control::read_task(control::task_file(text::tree_file("config/tasks"), options.task))};
  const bool is_chosen = options.budget > 0 || options.tolerance > 0;
  if (!options.from.empty() && !is_chosen) {
    throw geometry::InputError(
        "--from is of what --budget or --tolerance choose, and neither is given",
        "Give one of them, or leave --from away");
  }
  const std::string from = options.from.empty() ? "images" : options.from;
  for (const std::string& name : options.platforms) {
    const eval::PlatformUnderTest& platform =
        platforms.emplace_back(robot::platform_file(options.robots, name), choice);
    eval::ChainOptions& chain = chains.emplace_back();
    if (!is_chosen) continue;
    const fidelity::ChosenChain chosen =
        fidelity::choose_chain(text::tree_file("config/fidelity"),
                               fidelity::chain_front_name(fidelity::chain_input(from),
                                                          platform.hand().name, platform.name()),
                               options.budget, options.tolerance);
    chain = eval::chain_options(chosen);
    const std::string setting =
        fmt::format("{}: {} ({})\n", platform.name(), to_string(chosen.setting),
                    measured_text(chosen.front, chosen.setting));
    std::printf("%s", setting.c_str());
    runs.setting += setting;
  }
  const std::vector<eval::PlannerSetting> settings = eval::compared_settings(options.planned_on);
  const std::vector<eval::DataSet> sets = eval::chosen_data_sets(options.choice);
  const std::vector<eval::Case> views = eval::chosen_cases(sets, options.choice);
  if (options.choice.list) return eval::list_cases(views);
  const auto evidence = std::find_if(kEvidence.begin(), kEvidence.end(), [&](const auto& one) {
    return one.first == options.evidence;
  });
  std::vector<PlatformCase> cases;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < platforms.size(); ++i) {
    const eval::PlatformUnderTest& platform = platforms[i];
    std::string run = platform.name() + (options.open_loop ? "_open_loop_" : "_");
    if (options.task != control::pick_and_place().name) run += options.task + "_";
    if (evidence->second != kEvidence.back().second) run += evidence->first + "_";
    for (const eval::Case& one : views) {
      cases.push_back({one, &platform, &chains[i]});
      names.push_back(run + one.result_name());
    }
  }
  const auto results = eval::found_results(eval::run_cases(
      runs, names, eval::read_grasp_case,
      [&](int i) {
        return eval::run_grasp_case(cases[i].one, *cases[i].platform, settings, evidence->second,
                                    *cases[i].chain);
      },
      [&](const eval::GraspCase& known) { return is_complete(known, settings); }));
  std::printf("%s", eval::grasp_text(results).c_str());
  if (!options.choice.json.empty())
    eval::write_text(options.choice.json, eval::grasp_json(results));
  eval::write_grasp_report(options.choice.runs.out, results);
  std::printf("\n%s\n", (options.choice.runs.out / "index.html").c_str());
  return results.size() == cases.size() ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Sees known bodies once, by a rendered stereo pair, plans grasps on the predicted shape, on "
      "the truth and on the Delaunay baseline, and executes them in simulation on the truth. 12 "
      "household objects made by code (with PREHEND_SHARED_DATA scanned ones as well), some also "
      "lying, in 8 orientations, or the groups that are named; what an object stands on, leans on "
      "or is hidden by is rendered, is an obstacle, and does not move. A run that was interrupted "
      "goes on where it was.");
  eval::add_case_options(app, options.choice);
  app.add_option(
         "--platform", options.platforms,
         "arms with hands to evaluate, one or more: what is in --robots, or a file; planned "
         "with the arm's motion and executed by the cycle that runs on the robot")
      ->capture_default_str();
  app.add_option("--planned-on", options.planned_on,
                 "what grasps are executed that were planned on the predicted shape, the truth or "
                 "the Delaunay surface of what was seen. On the truth they are planned in any "
                 "case, as this tells whether an object fits the hand")
      ->check(CLI::IsMember(names_of_planned_on()))
      ->capture_default_str();
  CLI::Option* budget =
      app.add_option("--budget", options.budget,
                     "s of processor from images, or their cloud, to ranked grasps: how views are "
                     "seen, shapes "
                     "predicted and grasps planned, by the front of measured chains (planning is "
                     "not cut off)")
          ->transform(text::in_seconds())
          ->check(text::above_zero());
  app.add_option("--tolerance", options.tolerance, "m, of the predicted mesh, likewise")
      ->transform(text::in_metres())
      ->check(text::above_zero())
      ->excludes(budget);
  app.add_option("--from", options.from,
                 "images or cloud: what the chain begins with that --budget or --tolerance choose; "
                 "a cloud is seen by the defaults before. Default: images")
      ->check(CLI::IsMember({"images", "cloud"}));
  std::vector<std::string> uses;
  for (const auto& [name, use] : kEvidence) uses.push_back(name);
  app.add_option("--evidence", options.evidence,
                 "what of a failed attempt is put to use when the object is seen again: where it "
                 "was touched, what the hand went through without a touch, what was seen of it "
                 "before; each with those before it")
      ->check(CLI::IsMember(uses))
      ->capture_default_str();
  app.add_flag("--open-loop", options.open_loop,
               "the approach does not stop where the hand touches");
  app.add_option("--task", options.task,
                 "that is executed: pick_and_place, or decide_and_pick, which feels first where "
                 "the plan says that this is worth it")
      ->check(CLI::IsMember({"pick_and_place", "decide_and_pick"}))
      ->capture_default_str();
  app.add_option("--robots", options.robots, "folder of the platforms' files")
      ->check(CLI::ExistingDirectory)
      ->capture_default_str();
  return eval::parse_and_run(app, argc, argv, [&options] { return run(options); });
}
