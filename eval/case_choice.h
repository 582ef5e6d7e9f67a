#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "eval/case_runner.h"
#include "eval/case_runs.h"

namespace prehend::eval {

/// What is evaluated and where it goes: options of the programs that evaluate data sets seen in
/// several orientations.
struct CaseChoice {
  CaseRunOptions runs;
  std::filesystem::path json;
  std::filesystem::path meshes;
  std::vector<std::string> groups;
  std::vector<std::uint64_t> drawn;  // seeds of the group varied; empty: 1
  std::vector<std::string> only;
  bool quick = false;
  bool list = false;
  std::vector<std::uint64_t> seeds{1};
};

/// @param out the folder, unless --out names another one.
CaseChoice default_choice(const std::filesystem::path& out);
/// --out, --json, --groups, --drawn, --meshes, --only, --quick, --list, --seed, and those of
/// add_run_options(). @param views false: the bodies are not seen in orientations, there is no
/// --quick.
void add_case_options(CLI::App& app, CaseChoice& choice, bool views = true);

/// @throws geometry::InputError for a name of --only that none of `names` is, with the nearest;
/// `what` they name, as "data set".
void check_only(const std::vector<std::string>& only, const std::vector<std::string>& names,
                const std::string& what);
/// @throws geometry::InputError for one that is named twice.
void check_platforms(std::vector<std::string> platforms);

/// The data sets of the chosen groups or of the folder --meshes, see data_sets_to_evaluate(), of
/// which --only leaves those that it names. @throws geometry::InputError when --drawn has nothing
/// to apply to or a seed twice, or for a name that none has, with the nearest.
std::vector<DataSet> chosen_data_sets(const CaseChoice& choice);

/// The chosen cases of `sets`, which must outlive them: 8 orientations, 2 when quick, with each of
/// the seeds. @throws geometry::InputError for a seed twice.
std::vector<Case> chosen_cases(const std::vector<DataSet>& sets, const CaseChoice& choice);

/// The seeds. @throws geometry::InputError when one is there twice.
const std::vector<std::uint64_t>& chosen_seeds(const CaseChoice& choice);

/// The elements of what `make` makes of each of the seeds. @throws geometry::InputError as
/// chosen_seeds().
template <class Make>
auto of_each_seed(const CaseChoice& choice, const Make& make) {
  decltype(make(std::uint64_t())) all;
  for (const std::uint64_t seed : chosen_seeds(choice)) {
    for (auto& one : make(seed)) all.push_back(std::move(one));
  }
  return all;
}

/// Prints the names of the cases, for --list. Returns main()'s exit code.
int list_cases(const std::vector<Case>& cases);

/// Reads what is given and runs `work`; what it throws is printed. Returns main()'s exit code.
int parse_and_run(CLI::App& app, int argc, char** argv, const std::function<int()>& work);

}  // namespace prehend::eval
