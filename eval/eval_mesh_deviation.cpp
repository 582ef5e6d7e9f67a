// The paper's evaluation of predicted shapes (Bohg et al., "Mind the Gap", ICRA 2011, figures 10 to
// 12) on rendered stereo pairs of known bodies.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include <CLI/CLI.hpp>

#include "eval/case_choice.h"
#include "eval/confidence_fit.h"
#include "eval/deviation_summary.h"
#include "eval/mesh_deviation_report.h"
#include "eval/shape_comparison.h"
#include "eval/text_files.h"
#include "prehend/geometry/errors.h"

namespace {

using namespace prehend;
namespace fs = std::filesystem;

struct Options {
  eval::CaseChoice choice = eval::default_choice("out/mesh_deviation");
  fs::path fit_confidence;
  std::string comparison = "paper";
  std::vector<std::string> methods;

  const eval::ShapeComparison& compared() const {
    const auto& all = eval::shape_comparisons();
    return *std::find_if(all.begin(), all.end(), [&](const eval::ShapeComparison& one) {
      return one.name == comparison;  // checked when it was parsed
    });
  }
};

// Whether it is of every method.
bool is_complete(const eval::CaseResult& result, const std::vector<eval::Method>& methods) {
  if (!result.problem.empty()) return true;
  return std::all_of(methods.begin(), methods.end(), [&](const eval::Method& method) {
    return std::any_of(result.methods.begin(), result.methods.end(),
                       [&](const eval::MethodResult& m) { return m.method == method.name; });
  });
}

void fit_confidence(const std::vector<eval::CaseResult>& results, const fs::path& file) {
  std::vector<eval::JudgedEvidence> judged;
  std::vector<std::string> groups;  // one a judged completion
  for (const eval::CaseResult& result : results) {
    for (const eval::MethodResult& method : result.methods) {
      if (!method.evidence || std::isnan(method.mean)) continue;
      const std::string object = result.data_set.substr(0, result.data_set.find("_lying"));
      judged.push_back({*method.evidence, eval::is_right(method), object});
      groups.push_back(result.group);
    }
  }
  if (judged.empty()) {
    throw geometry::InputError("There is no evidence to learn from",
                               "Evaluate some objects by the method Ours");
  }
  const shape::ConfidenceModel model = eval::fitted_confidence(judged);
  eval::write_text(file, eval::to_yaml(model));
  std::printf("\nConfidence learnt, to '%s':\n%s", file.c_str(), eval::to_yaml(model).c_str());
  const std::vector<double> left_out = eval::cross_validated(judged);
  for (const std::string& group : std::set<std::string>(groups.begin(), groups.end())) {
    std::vector<eval::JudgedEvidence> of_group;
    std::vector<double> of_others;  // confidence when the object is left out
    for (std::size_t i = 0; i < judged.size(); ++i) {
      if (groups[i] != group) continue;
      of_group.push_back(judged[i]);
      of_others.push_back(left_out[i]);
    }
    const auto tell = [&](const char* name, const eval::Calibration& c) {
      std::printf("  %-10s %-24s >= 90 %% sure: %d of %zu, right: %d, of %d that are right\n",
                  group.c_str(), name, c.sure, of_group.size(), c.right, c.all_right);
    };
    tell("present", eval::calibration_of(of_group, shape::ConfidenceModel(), 0.9));
    tell("learnt from the others", eval::calibration_of(of_group, of_others, 0.9));
    tell("learnt from all", eval::calibration_of(of_group, model, 0.9));
  }
}

int run(const Options& options) {
  const std::vector<eval::DataSet> sets = eval::chosen_data_sets(options.choice);
  const std::vector<eval::Case> cases = eval::chosen_cases(sets, options.choice);
  if (options.choice.list) return eval::list_cases(cases);
  const eval::ShapeComparison& comparison = options.compared();
  const std::vector<eval::Method> methods =
      eval::methods_named(options.methods.empty() ? comparison.methods : options.methods);
  eval::CaseRunOptions runs = options.choice.runs;
  runs.setting = comparison.as_solids ? "as solids" : "";
  std::vector<std::string> case_names;
  for (const eval::Case& one : cases) case_names.push_back(one.result_name());
  const auto outcomes = eval::run_cases(
      runs, case_names, eval::read_case_result,
      [&](int i) { return eval::run_case(cases[i], methods, comparison.as_solids); },
      [&](const eval::CaseResult& known) { return is_complete(known, methods); });
  std::vector<eval::CaseResult> results;
  bool all_ended = true;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto& [found, problem] = outcomes[i];
    if (found) {
      results.push_back(*found);
      continue;
    }
    all_ended = false;
    const eval::Case& one = cases[i];
    eval::CaseResult result;
    result.case_name = one.name();
    result.group = one.data_set->group;
    result.data_set = one.data_set->name;
    result.orientation = one.orientation;
    result.problem = "The process ended: " + problem;
    results.push_back(std::move(result));
  }
  std::printf("%s", eval::mesh_deviation_text(results, methods, comparison).c_str());
  if (!options.choice.json.empty()) {
    eval::write_text(options.choice.json, eval::mesh_deviation_json(results, methods, comparison));
  }
  eval::write_mesh_deviation_report(options.choice.runs.out, results, methods, comparison);
  if (!options.fit_confidence.empty()) fit_confidence(results, options.fit_confidence);
  std::printf("\n%s\n", (options.choice.runs.out / "index.html").c_str());
  return all_ended ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Predicts the shape of known bodies from rendered stereo pairs and measures how far the "
      "meshes are from the truth. 16 data sets (12 household objects made by code, four of them "
      "also lying; with PREHEND_SHARED_DATA as many scanned ones) in 8 orientations. A run that "
      "was interrupted goes on where it was.");
  eval::add_case_options(app, options.choice);
  std::vector<std::string> comparisons, names;
  std::string about = "what is compared:";
  for (const eval::ShapeComparison& one : eval::shape_comparisons()) {
    comparisons.push_back(one.name);
    about += " " + one.name + ": " + one.description + ";";
  }
  about.back() = '.';
  for (const eval::Method& method : eval::known_methods()) names.push_back(method.name);
  app.add_option("--compare", options.comparison, about)
      ->check(CLI::IsMember(comparisons))
      ->capture_default_str();
  app.add_option("--methods", options.methods, "the methods to compare; default: the comparison's")
      ->check(CLI::IsMember(names));
  app.add_option(
      "--fit-confidence", options.fit_confidence,
      "learn the confidence model from all results, write it to this file, and tell how it does "
      "on each object when learnt from the others");
  return eval::parse_and_run(app, argc, argv, [&options] { return run(options); });
}
