// What touches make of a predicted shape.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "eval/belief/touch_trial.h"
#include "eval/case_choice.h"
#include "eval/case_runs.h"
#include "eval/deviation_summary.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/tree_file.h"

namespace {

using namespace prehend;
namespace fs = std::filesystem;

struct Options {
  eval::CaseChoice choice = eval::default_choice("out/belief");
  std::optional<int> touches;
  std::string hand;  // empty: a fingertip

  int count() const { return touches.value_or(hand.empty() ? 5 : 3); }
};

bool is_known(const fs::path& file) {
  if (!fs::exists(file)) return false;
  try {
    eval::read_belief_case(file);
    return true;
  } catch (const geometry::InputError& error) {
    std::printf("%s\n", error.what());
    return false;
  }
}

int run(const Options& options) {
  const std::vector<eval::DataSet> sets = eval::chosen_data_sets(options.choice);
  const std::vector<eval::Case> cases = eval::chosen_cases(sets, options.choice);
  if (options.choice.list) return eval::list_cases(cases);
  const eval::CaseRunOptions runs = options.choice.runs();
  std::vector<std::string> names;
  for (const eval::Case& one : cases) {
    names.push_back(one.result_name() + (options.hand.empty() ? "" : "_" + options.hand));
  }
  std::optional<eval::TouchingHand> hand;
  if (!options.hand.empty()) hand.emplace(options.hand);
  eval::TouchTrialOptions trial;
  trial.touches = options.count();
  trial.hand = hand ? &*hand : nullptr;
  const auto crashed = eval::run_cases(
      runs, names, [&](int, const fs::path& file) { return is_known(file); },
      [&](int i, const fs::path& file) {
        eval::write_belief_case(file, eval::run_touch_trial(cases[i], trial));
      });
  std::vector<eval::BeliefCase> results;
  for (int i = 0; i < static_cast<int>(cases.size()); ++i) {
    const fs::path file = eval::case_file(runs, names[i]);
    if (is_known(file)) results.push_back(eval::read_belief_case(file));
  }
  // Mean over cases by touches; a series that ended early keeps its last step.
  std::map<std::string, std::vector<std::vector<eval::BeliefStep>>> by_series;
  for (const eval::BeliefCase& result : results) {
    if (!result.problem.empty()) {
      std::printf("%s: %s\n", result.case_name.c_str(), result.problem.c_str());
    }
    for (const eval::BeliefSeries& series : result.series) {
      if (series.steps.empty()) continue;
      auto& steps = by_series[series.name];
      steps.emplace_back();
      for (int t = 0; t <= options.count(); ++t) {
        steps.back().push_back(series.steps[std::min<std::size_t>(t, series.steps.size() - 1)]);
      }
    }
  }
  for (const auto& [name, all] : by_series) {
    std::printf("%s, %zu views\n", name.c_str(), all.size());
    std::printf("touches  unseen mm  change  chamfer mm  change  jaccard  worse  update ms\n");
    double first_unseen = 0, first_chamfer = 0;
    for (int t = 0; t <= options.count(); ++t) {
      std::vector<double> unseen, chamfer, jaccard, seconds;
      int worse = 0;
      for (const auto& steps : all) {
        unseen.push_back(steps[t].unseen);
        chamfer.push_back(steps[t].chamfer);
        jaccard.push_back(steps[t].jaccard);
        seconds.push_back(steps[t].seconds);
        worse += t > 0 && steps[t].unseen > steps[t - 1].unseen + 3e-4;
      }
      const double u = eval::spread_of(unseen).mean, c = eval::spread_of(chamfer).mean;
      if (t == 0) {
        first_unseen = u;
        first_chamfer = c;
      }
      std::printf("%7d  %9.2f  %+5.0f%%  %10.2f  %+5.0f%%  %7.3f  %4.1f%%  %9.1f\n", t, 1e3 * u,
                  100 * (u / first_unseen - 1), 1e3 * c, 100 * (c / first_chamfer - 1),
                  eval::spread_of(jaccard).mean, 100.0 * worse / static_cast<double>(all.size()),
                  1e3 * eval::spread_of(seconds).mean);
    }
  }
  return crashed.empty() ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Touches predicted objects and measures what that makes of their shapes.");
  eval::add_case_options(app, options.choice);
  app.add_option("--touches", options.touches, "of each object; 5, of a hand 3")
      ->check(CLI::Range(1, 20));
  std::vector<std::string> hands = robot::platform_names(text::tree_file("config/robots"));
  for (const std::string& name : robot::hand_names(text::tree_file("config/robots"))) {
    hands.push_back(name);
  }
  app.add_option("--hand", options.hand,
                 "a platform or a hand of config/robots, which touches by closing as its grasps "
                 "are planned; else a fingertip touches")
      ->check(CLI::IsMember(hands));
  return eval::parse_and_run(app, argc, argv, [&options] { return run(options); });
}
