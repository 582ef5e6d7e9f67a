// What touches make of a predicted shape.

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "eval/belief/belief_report.h"
#include "eval/belief/look_trial.h"
#include "eval/belief/prior_fit.h"
#include "eval/belief/surprise_report.h"
#include "eval/belief/touch_trial.h"
#include "eval/case_choice.h"
#include "eval/case_runs.h"
#include "eval/text_files.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/command_line.h"
#include "prehend/text/tree_file.h"

namespace {

using namespace prehend;
namespace fs = std::filesystem;

struct Options {
  eval::CaseChoice choice = eval::default_choice("out/belief");
  std::optional<int> touches;
  std::optional<int> looks;  // in place of touches
  std::string hand;          // empty: a fingertip
  bool fit_prior = false;
  bool surprise = false;
  std::filesystem::path fit;

  std::string robot() const { return hand.empty() ? "kr5_sdh" : hand; }
  int count() const { return touches.value_or(hand.empty() ? 5 : 3); }
};

constexpr const char* kModelsOfSurprise = "config/touch/percept_surprise";
constexpr const char* kFitGroup = "household";
constexpr double kFalseAlarms = 0.02;  // of right predictions: the goal

int run_surprise(const Options& options) {
  if (options.fit_prior) {
    throw geometry::InputError("--fit-prior does not go with --surprise", "Leave it out");
  }
  if (options.choice.runs.mpi) {
    throw geometry::InputError("--mpi does not go with --surprise", "Leave it out");
  }
  if (options.touches) {
    throw geometry::InputError("--touches does not go with --surprise", "Leave it out");
  }
  if (options.looks) {
    throw geometry::InputError("--looks does not go with --surprise", "Leave it out");
  }
  const std::vector<eval::DataSet> sets = eval::chosen_data_sets(options.choice);
  std::vector<eval::Case> cases = eval::chosen_cases(sets, options.choice);
  // Each case is a dozen acts: one orientation when quick.
  if (options.choice.quick) std::erase_if(cases, [](const auto& one) { return one.orientation; });
  if (options.choice.list) return eval::list_cases(cases);
  const std::string name = options.hand.empty() ? "kr5_sdh" : options.hand;
  const eval::TouchingHand hand(name);
  belief::SurpriseModel model;
  if (options.fit.empty()) {
    model = belief::SurpriseModel::load_for(text::tree_file(kModelsOfSurprise), hand.model().name);
    if (model.hand != hand.model().name) {
      throw geometry::InputError("No model of surprise was fitted to " + hand.model().name,
                                 "Fit one: --fit FILE");
    }
  }
  std::vector<eval::SurpriseCase> results;
  for (const eval::Case& one : cases) {
    results.push_back(eval::run_surprise_trial(one, hand));
    const eval::SurpriseCase& done = results.back();
    std::fprintf(stderr, "%zu of %zu: %s: %zu acts %s\n", results.size(), cases.size(),
                 done.name.c_str(), done.acts.size(), done.problem.c_str());
  }
  if (!options.fit.empty())
    model = eval::fitted_surprise(results, kFitGroup, kFalseAlarms, hand.model());
  const eval::SurpriseFindings findings = eval::surprise_findings(results, model);
  const std::string said = eval::surprise_text(findings);
  std::printf("\n%s", said.c_str());
  if (!options.choice.json.empty()) {
    eval::write_text(options.choice.json, eval::surprise_json(findings));
  }
  eval::write_surprise_report(options.choice.runs.out, findings, results, model);
  std::printf("\n%s\n", (options.choice.runs.out / "index.html").c_str());
  if (!options.fit.empty()) {
    model.hand = hand.model().name;
    model.save(options.fit, fmt::format("Fitted by eval_belief --surprise --fit FILE --hand {} on "
                                        "the {} objects; measured there:\n{}",
                                        name, kFitGroup, said));
    std::printf("%s\n", options.fit.c_str());
  }
  return EXIT_SUCCESS;
}

int run(const Options& options) {
  if (options.surprise) return run_surprise(options);
  if (!options.fit.empty()) {
    throw geometry::InputError("--fit goes with --surprise only", "Add --surprise");
  }
  if (options.looks && (options.touches || options.fit_prior)) {
    throw geometry::InputError("--touches and --fit-prior do not go with --looks",
                               "Leave them out");
  }
  const std::vector<eval::DataSet> sets = eval::chosen_data_sets(options.choice);
  const std::vector<eval::Case> cases = eval::chosen_cases(sets, options.choice);
  if (options.choice.list) return eval::list_cases(cases);
  eval::CaseRunOptions runs = options.choice.runs;
  runs.setting = options.looks ? fmt::format("{} looks with {}", *options.looks, options.robot())
                               : fmt::format("{} touches by {}", options.count(),
                                             options.hand.empty() ? "a fingertip" : options.hand);
  std::vector<std::string> names;
  for (const eval::Case& one : cases) names.push_back(one.result_name());
  std::optional<eval::TouchingHand> hand;
  std::optional<eval::LookingRobot> robot;
  if (options.looks) {
    robot.emplace(options.robot());
  } else if (!options.hand.empty()) {
    hand.emplace(options.hand);
  }
  eval::LookTrialOptions look;
  look.looks = options.looks.value_or(0);
  eval::TouchTrialOptions trial;
  trial.touches = options.count();
  trial.hand = hand ? &*hand : nullptr;
  const auto results =
      eval::found_results(eval::run_cases(runs, names, eval::read_belief_case, [&](int i) {
        return robot ? eval::run_look_trial(cases[i], *robot, look)
                     : eval::run_touch_trial(cases[i], trial);
      }));
  std::printf("\n%s", eval::belief_text(results).c_str());
  if (options.fit_prior) std::printf("\n%s", eval::prior_fit_text(results).c_str());
  if (!options.choice.json.empty()) {
    eval::write_text(options.choice.json, eval::belief_json(results));
  }
  eval::write_belief_report(options.choice.runs.out, results);
  std::printf("\n%s\n", (options.choice.runs.out / "index.html").c_str());
  return results.size() == cases.size() ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Predicts the shape of known bodies from rendered stereo pairs, touches them where "
      "that tells most, and measures how far the corrected shapes are from the truth. A run "
      "that was interrupted goes on where it was.");
  eval::add_case_options(app, options.choice);
  app.add_option("--touches", options.touches, "of each object; 5, of a hand 3")
      ->check(text::in_range(1, 20));
  app.add_option("--looks", options.looks,
                 "in place of touching, the arm of --hand (a platform, kr5_sdh) grasps the object "
                 "and turns it before the camera, or where it carries the camera looks from "
                 "elsewhere, so often at most")
      ->check(text::in_range(1, 16));
  app.add_flag("--fit-prior", options.fit_prior,
               "also fit the weights that shapes have before a touch (ShapePrior), and tell how "
               "well they do on objects that they were not fitted to");
  std::vector<std::string> hands = robot::platform_names(text::tree_file("config/robots"));
  for (const std::string& name : robot::hand_names(text::tree_file("config/robots"))) {
    hands.push_back(name);
  }
  app.add_option("--hand", options.hand,
                 "a platform or a hand of config/robots, which touches by closing as its grasps "
                 "are planned; else a fingertip touches")
      ->check(CLI::IsMember(hands));
  app.add_flag("--surprise", options.surprise,
               "in place of touching, closes --hand (kr5_sdh) on objects that are as predicted, "
               "or of another size, moved, fallen, slippery, not there, and says how many bits of "
               "surprise that is; one process, always fresh");
  app.add_option("--fit", options.fit,
                 "with --surprise: fits the model of surprise on the household objects and writes "
                 "it: config/touch/percept_surprise/HAND.yaml");
  return eval::parse_and_run(app, argc, argv, [&options] { return run(options); });
}
