#include "eval/case_runs.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "eval/process_pool.h"
#include "eval/text_files.h"

namespace prehend::eval {
namespace {

namespace fs = std::filesystem;

// Results of another build are no results of this one.
std::string identity_of_this_program() {
  const fs::path self = fs::canonical("/proc/self/exe");
  return fmt::format("{} bytes, changed {}\n", fs::file_size(self),
                     fs::last_write_time(self).time_since_epoch().count());
}

void prepare_cases_folder(const fs::path& folder, bool fresh) {
  const fs::path stamp = folder / "made_by";
  std::string made_by;
  if (std::ifstream stream(stamp); stream) std::getline(stream, made_by);
  const std::string self = identity_of_this_program();
  if (fresh || (!made_by.empty() && made_by + "\n" != self)) {
    std::printf("Starting afresh: the results in '%s' are %s.\n", folder.c_str(),
                fresh ? "not wanted" : "of another build");
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

std::vector<DataSet> data_sets_to_evaluate(const fs::path& meshes) {
  if (!meshes.empty()) {
    const fs::path folder = fs::canonical(meshes);
    return make_data_sets(folder.filename().string(), objects_of_folder(folder));
  }
  std::vector<DataSet> sets = make_data_sets("household", household_objects());
  const char* shared = std::getenv("PREHEND_SHARED_DATA");
  if (shared != nullptr && *shared != '\0') {
    const auto scanned = make_data_sets("scanned", scanned_objects(shared));
    sets.insert(sets.end(), scanned.begin(), scanned.end());
  } else {
    std::printf("Without scanned meshes: PREHEND_SHARED_DATA does not name a folder.\n");
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
  prepare_cases_folder(options.out / "cases", options.fresh);
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
