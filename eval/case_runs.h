#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "eval/data_sets.h"

namespace prehend::eval {

/// Names of groups: "household", "scanned", "hard", "held" and "varied", see household_objects.h,
/// hard_objects.h and varied_scenes.h.
std::vector<std::string> known_groups();

/// The data sets of `groups`; of none: household and, where PREHEND_SHARED_DATA names their folder,
/// scanned (says so when not). Or those of the folder `meshes` alone, if that is not empty. The
/// group varied has the scenes of each of `drawn`, the seeds.
/// @throws geometry::InputError as objects_of_folder() and scanned_objects(), for an unknown group,
/// and for scanned without PREHEND_SHARED_DATA.
std::vector<DataSet> data_sets_to_evaluate(const std::filesystem::path& meshes,
                                           const std::vector<std::string>& groups = {},
                                           const std::vector<std::uint64_t>& drawn = {1});

/// How cases are run.
struct CaseRunOptions {
  std::filesystem::path out;  // folder; results are in its results.db
  int processes = 1;          // >= 1
  bool mpi = false;           // this is one of several ranks, see sweep::hand_out_to_ranks()
  double lost_after = 30;     // s, of a rank's silence
  bool fresh = false;         // forget the results of earlier runs
  double timeout = 0;         // s, of a case; 0: none
  std::string setting = {};   // what the cases are run with, in words; see run_cases()
};

/// --processes, --mpi, --lost-after, --fresh. `runs` lives as long as the app.
void add_run_options(CLI::App& app, CaseRunOptions& runs);

/// What became of a case.
template <class Result>
struct CaseOutcome {
  std::optional<Result> result;
  std::string problem;  // why there is none
};

/// Runs those of the cases whose result is not known yet, each in a process of its own, with their
/// progress on the terminal; those that took longest in an earlier run begin first, and a case
/// whose process or rank was killed is given out again. Results are texts in one SQLite file
/// (sweep::ResultStore), written as each case ends: who is stopped goes on when started again.
/// Results of another build of the program, or of another setting, are forgotten. What ends with an
/// error is printed with its last lines, and tried again by the next run.
///
/// `is_whole` says whether the case's text is a result, `run` makes it in the case's process.
/// Where the user stops it, and in ranks other than the first, this process ends here.
/// @throws geometry::InputError when another run uses the folder, or it cannot be written.
std::vector<CaseOutcome<std::string>> run_text_cases(
    const CaseRunOptions& options, const std::vector<std::string>& names,
    const std::function<bool(const std::string& text)>& is_whole,
    const std::function<std::string(int)>& run);

/// The same of results that `to_text` writes and `read` reads, which throws geometry::InputError
/// for what is no result. `is_wanted` says whether a result is what is asked for.
template <class Run, class Read, class Result = std::invoke_result_t<Run, int>>
std::vector<CaseOutcome<Result>> run_cases(
    const CaseRunOptions& options, const std::vector<std::string>& names, const Read& read,
    const Run& run,
    const std::function<bool(const std::type_identity_t<Result>&)>& is_wanted = [](const Result&) {
      return true;
    }) {
  std::vector<CaseOutcome<Result>> outcomes;
  for (const auto& [text, problem] : run_text_cases(
           options, names, [&](const std::string& known) { return is_wanted(read(known)); },
           [&](int i) { return to_text(run(i)); })) {
    outcomes.push_back({text ? std::optional<Result>(read(*text)) : std::nullopt, problem});
  }
  return outcomes;
}

/// The results that are there.
template <class Result>
std::vector<Result> found_results(std::vector<CaseOutcome<Result>> outcomes) {
  std::vector<Result> results;
  for (CaseOutcome<Result>& one : outcomes) {
    if (one.result) results.push_back(std::move(*one.result));
  }
  return results;
}

}  // namespace prehend::eval
