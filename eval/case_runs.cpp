#include "eval/case_runs.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "eval/hard_objects.h"
#include "eval/household_objects.h"
#include "eval/process_pool.h"
#include "eval/text_files.h"
#include "eval/varied_scenes.h"
#include "prehend/geometry/errors.h"

namespace prehend::eval {
namespace {

namespace fs = std::filesystem;

// Results of another build are no results of this one.
std::string identity_of_this_program() {
  const fs::path self = fs::canonical("/proc/self/exe");
  return fmt::format("{} bytes, changed {}\n", fs::file_size(self),
                     fs::last_write_time(self).time_since_epoch().count());
}

void prepare_cases_folder(const fs::path& folder, const CaseRunOptions& options) {
  const fs::path stamp = folder / "made_by";
  std::string made_by;
  if (std::ifstream stream(stamp); stream) {
    made_by.assign(std::istreambuf_iterator<char>(stream), {});
  }
  const std::string self = identity_of_this_program() + options.setting;
  if (options.fresh || (!made_by.empty() && made_by != self)) {
    std::printf("Starting afresh: the results in '%s' are %s.\n", folder.c_str(),
                options.fresh ? "not wanted" : "of another build or setting");
    fs::remove_all(folder);
  }
  write_text(stamp, self);
}

void show_progress(const PoolProgress& progress, std::size_t known) {
  static const bool terminal = isatty(STDOUT_FILENO) != 0;
  static int last = -1;
  if (progress.done == last && !terminal) return;
  const bool every = terminal || progress.done == progress.total || progress.done % 16 == 0;
  if (!every || (progress.done == last && progress.done == 0)) return;
  last = progress.done;
  const double left =
      progress.done > 0 ? progress.seconds / progress.done * (progress.total - progress.done) : 0;
  std::printf("%s%d of %d cases (%zu known before), %.0f s, about %.0f s left%s",
              terminal ? "\r" : "", progress.done, progress.total, known, progress.seconds, left,
              terminal ? "   " : "\n");
  std::fflush(stdout);
}

}  // namespace

std::vector<std::string> known_groups() {
  return {"household", "scanned", "hard", "held", "varied"};
}

std::vector<DataSet> data_sets_to_evaluate(const fs::path& meshes,
                                           const std::vector<std::string>& groups,
                                           const std::vector<std::uint64_t>& drawn) {
  if (!meshes.empty()) {
    const fs::path folder = fs::weakly_canonical(meshes);
    return make_data_sets(folder.filename().string(), objects_of_folder(folder));
  }
  const char* shared = std::getenv("PREHEND_SHARED_DATA");
  const bool has_scans = shared != nullptr && *shared != '\0';
  std::vector<std::string> wanted = groups;
  if (wanted.empty()) {
    wanted = {"household"};
    if (has_scans) {
      wanted.push_back("scanned");
    } else {
      std::printf("Without scanned meshes: PREHEND_SHARED_DATA does not name a folder.\n");
    }
  }
  std::vector<DataSet> sets;
  for (const std::string& group : wanted) {
    std::vector<EvaluationObject> objects;
    if (group == "household") objects = household_objects();
    if (group == "hard") objects = hard_objects();
    if (group == "held") objects = held_out_objects();
    for (const std::uint64_t seed : group == "varied" ? drawn : std::vector<std::uint64_t>{}) {
      for (EvaluationObject& one : varied_scenes(seed)) objects.push_back(std::move(one));
    }
    if (group == "scanned") {
      if (!has_scans) {
        throw geometry::InputError("The group scanned needs its meshes",
                                   "Let PREHEND_SHARED_DATA name their folder");
      }
      objects = scanned_objects(shared);
    }
    if (objects.empty()) {
      throw geometry::InputError("There is no group '" + group + "'",
                                 "Give some of household, scanned, hard, held, varied");
    }
    const std::vector<DataSet> made = make_data_sets(group, objects);
    sets.insert(sets.end(), made.begin(), made.end());
  }
  return sets;
}

fs::path case_file(const CaseRunOptions& options, const std::string& name) {
  return options.out / "cases" / (name + ".yaml");
}

std::map<int, std::string> run_cases(const CaseRunOptions& options,
                                     const std::vector<std::string>& names,
                                     const std::function<bool(int, const fs::path&)>& known,
                                     const std::function<void(int, const fs::path&)>& run) {
  prepare_cases_folder(options.out / "cases", options);
  std::vector<int> open;
  for (int i = 0; i < static_cast<int>(names.size()); ++i) {
    if (!known(i, case_file(options, names[i]))) open.push_back(i);
  }
  std::map<int, std::string> crashed;
  if (open.empty()) return crashed;
  cv::setNumThreads(1);  // the processes share the cores
  for (const CrashedTask& task : run_in_processes(
           static_cast<int>(open.size()), options.processes, options.out / "output.txt",
           [&](int i) { run(open[i], case_file(options, names[open[i]])); },
           [&](const PoolProgress& p) { show_progress(p, names.size() - open.size()); })) {
    crashed[open[task.task]] = task.how;
  }
  std::printf("\n");
  return crashed;
}

}  // namespace prehend::eval
