#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "eval/data_sets.h"

namespace prehend::eval {

/// The household objects and, where PREHEND_SHARED_DATA names their folder, the scanned ones (says
/// so when not); or those of the folder `meshes` alone, if that is not empty.
/// @throws geometry::InputError as objects_of_folder() and scanned_objects().
std::vector<DataSet> data_sets_to_evaluate(const std::filesystem::path& meshes);

/// How many cases are run.
struct CaseRunOptions {
  std::filesystem::path out;  // folder; results of single cases are in its folder cases/
  int processes = 1;          // >= 1
  bool fresh = false;         // forget the results of earlier runs
};

/// Runs those of the cases whose result is not known yet, in processes of their own, with their
/// progress on the terminal. Results of another build of the program are forgotten. `known` says
/// whether the file holds a result, `run` makes it; each is given the case's index and file.
/// Returns how processes ended that crashed, by the case's index: the next run tries these again.
std::map<int, std::string> run_cases(
    const CaseRunOptions& options, const std::vector<std::string>& names,
    const std::function<bool(int, const std::filesystem::path&)>& known,
    const std::function<void(int, const std::filesystem::path&)>& run);

/// Where run_cases() keeps the result of the case.
std::filesystem::path case_file(const CaseRunOptions& options, const std::string& name);

}  // namespace prehend::eval
