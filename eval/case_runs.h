#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

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

/// How many cases are run.
struct CaseRunOptions {
  std::filesystem::path out;  // folder; results of single cases are in its folder cases/
  int processes = 1;          // >= 1
  bool fresh = false;         // forget the results of earlier runs
  std::string setting;        // what the cases are run with, in words; see run_cases()
};

/// Runs those of the cases whose result is not known yet, in processes of their own, with their
/// progress on the terminal. Results of another build of the program, or of
/// another setting, are forgotten. `known` says
/// whether the file holds a result, `run` makes it; each is given the case's index and file.
/// Returns how processes ended that crashed, by the case's index: the next run tries these again.
std::map<int, std::string> run_cases(
    const CaseRunOptions& options, const std::vector<std::string>& names,
    const std::function<bool(int, const std::filesystem::path&)>& known,
    const std::function<void(int, const std::filesystem::path&)>& run);

/// Where run_cases() keeps the result of the case.
std::filesystem::path case_file(const CaseRunOptions& options, const std::string& name);

}  // namespace prehend::eval
