#include "eval/case_runs.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <sstream>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "eval/hard_objects.h"
#include "eval/household_objects.h"
#include "eval/text_files.h"
#include "eval/varied_scenes.h"
#include "prehend/geometry/errors.h"
#include "prehend/sweep/results.h"
#include "prehend/sweep/workers/folder_lock.h"
#include "prehend/sweep/workers/mpi_ranks.h"
#include "prehend/sweep/workers/run_cases.h"
#include "prehend/sweep/workers/said_progress.h"
#include "prehend/text/command_line.h"

namespace prehend::eval {
namespace {

namespace fs = std::filesystem;

// Results of another build are no results of this one.
std::string identity_of_this_program() {
  const fs::path self = fs::canonical("/proc/self/exe");
  return fmt::format("{} bytes, changed {}", fs::file_size(self),
                     fs::last_write_time(self).time_since_epoch().count());
}

constexpr const char* kResultFile = "result.txt";  // in the case's folder

fs::path folder_of(const CaseRunOptions& options, const std::string& name) {
  return fs::absolute(options.out) / "cases" / name;
}

sweep::CaseOrder order_of(const CaseRunOptions& options, const std::string& name,
                          std::int64_t index) {
  sweep::CaseOrder order;
  order.index = index;
  order.name = name;
  order.folder = folder_of(options, name).string();
  order.results = {sweep::ResultSource::Kind::kText, kResultFile, {}};
  order.timeout = options.timeout;
  order.keep = false;
  return order;
}

void forget_others(const CaseRunOptions& options, sweep::ResultStore& store) {
  const std::map<std::string, std::string> fixed{{"build", identity_of_this_program()},
                                                 {"setting", options.setting}};
  if (!options.fresh && store.agrees_with(fixed)) return;
  if (const auto counts = store.counts(); counts.done + counts.failed > 0) {
    std::printf("Starting afresh: the results in '%s' are %s.\n", options.out.c_str(),
                options.fresh ? "not wanted" : "of another build or setting");
  }
  store.begin_anew(fixed);
}

void say_failed(const sweep::CaseResult& result) {
  std::fprintf(stderr, "%s: %s\n", result.name.c_str(), result.problem.c_str());
  std::istringstream lines(result.output);
  for (std::string line; std::getline(lines, line);) {
    std::fprintf(stderr, "    %s\n", line.c_str());
  }
}

// The text of a result that is there.
std::optional<std::string> text_in(const sweep::CaseResult& result) {
  if (result.failed() || result.rows.rows.empty()) return std::nullopt;
  return result.rows.rows.front().front();
}

bool is_known(const sweep::ResultStore& store, const std::string& name,
              const std::function<bool(const std::string&)>& is_whole) {
  const std::optional<sweep::CaseResult> result = store.find(name);
  const std::optional<std::string> text = result ? text_in(*result) : std::nullopt;
  if (!text) return false;
  try {
    return is_whole(*text);
  } catch (const geometry::InputError& error) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), error.what());
    return false;
  }
}

// Runs what is open; false when the user stopped it.
bool run_open(const CaseRunOptions& options, const std::vector<std::string>& names,
              std::vector<sweep::OpenCase> open, sweep::Workers& workers,
              sweep::ResultStore& store) {
  sweep::Handout handout(std::move(open));
  sweep::SaidProgress said;
  const sweep::RunProgress progress = sweep::run_cases(
      handout, workers, store,
      [&](std::int64_t i) { return order_of(options, names[static_cast<std::size_t>(i)], i); },
      [&](const sweep::RunProgress& now) { said.say(now); });
  said.end();
  sweep::print_summary(progress);
  std::error_code ignored;  // it stays where cases failed
  fs::remove(options.out / "cases", ignored);
  if (!progress.is_stopped) return true;
  std::printf("Stopped. What ended is kept; start it again to go on\n");
  return false;
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

void add_run_options(CLI::App& app, CaseRunOptions& runs) {
  CLI::Option* processes = app.add_option("--processes", runs.processes, "how many work at a time")
                               ->check(text::in_range(1, 256))
                               ->capture_default_str();
  CLI::Option* mpi = app.add_flag("--mpi", runs.mpi,
                                  "under mpirun or srun: the first rank hands out, each other runs "
                                  "a case at a time");
  app.add_option("--lost-after", runs.lost_after,
                 "seconds of a rank's silence after which another gets its case")
      ->check(text::in_range(2.0, 86400.0))
      ->capture_default_str()
      ->needs(mpi);
  app.add_flag("--fresh", runs.fresh, "forget the results of earlier runs");
  mpi->excludes(processes);
}

std::vector<CaseOutcome<std::string>> run_text_cases(
    const CaseRunOptions& options, const std::vector<std::string>& names,
    const std::function<bool(const std::string& text)>& is_whole,
    const std::function<std::string(int)>& run) {
  cv::setNumThreads(1);  // the processes share the cores
  const sweep::CaseBody body = [&](const sweep::CaseOrder& order) {
    write_text(fs::path(order.folder) / kResultFile, run(static_cast<int>(order.index)));
  };
  std::vector<CaseOutcome<std::string>> outcomes;
  bool is_first = false;
  const auto lead = [&](sweep::Workers* ranks) {
    is_first = true;
    make_folder(options.out);
    const sweep::FolderLock lock(options.out / "lock", false, "'" + options.out.string() + "'");
    sweep::ResultStore store(options.out / "results.db");
    forget_others(options, store);
    std::vector<sweep::OpenCase> open;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const int index = static_cast<int>(i);
      if (!is_known(store, names[i], is_whole)) {
        open.push_back({index, store.seconds(names[i])});
      }
    }
    if (const std::size_t known = names.size() - open.size(); known > 0) {
      std::printf("%zu of %zu cases are known already\n", known, names.size());
    }
    if (!open.empty()) {
      const int count = std::min(options.processes, static_cast<int>(open.size()));
      const auto here = ranks ? nullptr : sweep::workers_here(count, body);
      if (!run_open(options, names, std::move(open), ranks ? *ranks : *here, store)) return 130;
    }
    for (const std::string& name : names) {
      const auto result = store.find(name);
      outcomes.push_back({result ? text_in(*result) : std::nullopt, "It was not run"});
      if (result) outcomes.back().problem = result->problem;
      if (result && result->failed()) say_failed(*result);
    }
    return 0;
  };
  const int code =
      options.mpi ? sweep::hand_out_to_ranks(options.lost_after, body,
                                             [&](sweep::Workers& ranks) { return lead(&ranks); })
                  : lead(nullptr);
  if (!is_first || code != 0) std::exit(code);
  return outcomes;
}

}  // namespace prehend::eval
