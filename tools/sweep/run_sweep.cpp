#include "tools/sweep/run_sweep.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <ostream>
#include <thread>

#include <fmt/format.h>

#include "prehend/sweep/cases.h"
#include "prehend/sweep/table.h"
#include "prehend/sweep/workers/mpi_ranks.h"
#include "prehend/sweep/workers/run_cases.h"
#include "prehend/sweep/workers/said_progress.h"
#include "prehend/text/input_error.h"
#include "tools/sweep/case_program.h"
#include "tools/sweep/folder.h"
#include "tools/sweep/hdf5_table.h"
#include "tools/sweep/said.h"
#include "tools/sweep/slurm_array.h"

namespace prehend::tools {
namespace {

namespace fs = std::filesystem;
using sweep::Case;
using sweep::CaseOrder;
using sweep::CaseResult;
using sweep::Cases;
using sweep::ResultStore;
using sweep::RunProgress;
using sweep::Workers;
using text::InputError;

class Sweep {
 public:
  /// `ranks`: who runs the cases; nullptr: processes of this one do.
  Sweep(const SweepChoices& choices, Workers* ranks)
      : choices_(choices),
        ranks_(ranks),
        description_(sweep::read_description(choices.file, lines_of)),
        cases_(description_),
        program_(case_program(description_.program)) {
    check_table(choices.export_file, true);
    check_table(choices.export_costs, false);
    check_only();
  }

  int run() {
    if (choices_.list) return list();
    if (choices_.out.empty()) {
      throw InputError("The results need a folder", "Name one by --out");
    }
    folder_ = std::make_unique<SweepFolder>(choices_.out);
    if (choices_.status) return look();
    return choices_.part.empty() ? run_whole() : run_part(Part::parse(choices_.part));
  }

 private:
  // Before anything runs.
  static void check_table(const std::string& file, bool may_be_hdf5) {
    const fs::path extension = fs::path(file).extension();
    if (file.empty() || extension == ".csv") return;
    if (extension != ".h5" || !may_be_hdf5) {
      throw InputError("A table cannot be written as '" + file + "'",
                       may_be_hdf5 ? "Name a .csv or .h5 file" : "Name a .csv file");
    }
    check_hdf5();
  }

  void check_only() const {
    if (choices_.only.empty()) return;
    for (std::int64_t i = 0; i < cases_.size(); ++i) {
      if (is_chosen(cases_.at(i).name)) return;
    }
    throw InputError("No case has a name like '" + choices_.only + "', which --only gives",
                     "See the names by --list");
  }

  int list() const {
    for (std::int64_t i = 0; i < cases_.size(); ++i) {
      const std::string name = cases_.at(i).name;
      if (is_chosen(name)) fmt::print("{}\n", name);
    }
    return 0;
  }

  int look() const {
    const FolderResults results(*folder_);
    results.check(description_);
    const auto find = [&](const std::string& name) { return results.find(name); };
    print_status(cases_, find, command());
    export_tables(find, [&](const std::string& name) { return results.seconds(name); });
    return 0;
  }

  int run_whole() {
    const auto lock = folder_->lock_whole();
    ResultStore store(folder_->results());
    store.bind_to(description_);
    FolderResults(*folder_).check(description_);
    if (const int merged = folder_->merge_into(store); merged > 0) {
      fmt::print("The results of {} parts were taken into {}\n", merged,
                 folder_->results().string());
    }
    if (!choices_.again.empty()) forget(store);
    int code = 0;
    if (choices_.slurm > 0) {
      write_array();
    } else if (!choices_.merge) {
      code = run_open(store, store, nullptr);
    }
    const auto find = [&](const std::string& name) { return store.find(name); };
    if (choices_.merge) code = print_status(cases_, find, command()) ? 0 : 1;
    export_tables(find, [&](const std::string& name) { return store.seconds(name); });
    return code;
  }

  int run_part(const Part& part) {
    const auto locks = folder_->lock_part(part);
    const FolderResults others(*folder_, folder_->part(part));
    others.check(description_);
    ResultStore store(folder_->part(part));
    store.bind_to(description_);
    return run_open(store, others, &part);
  }

  bool is_chosen(const std::string& name) const {
    return choices_.only.empty() || sweep::matches(choices_.only, name);
  }

  // So that they are open; nothing else is run then.
  void forget(ResultStore& store) {
    std::int64_t forgotten = 0;
    for (std::int64_t i = 0; i < cases_.size(); ++i) {
      const std::string name = cases_.at(i).name;
      const auto known = store.find(name);
      const bool meant = choices_.again == "all"      ? true
                         : choices_.again == "failed" ? known && known->failed()
                                                      : sweep::matches(choices_.again, name);
      if (!meant || !is_chosen(name)) continue;
      if (known) store.forget(name);
      again_.push_back(i);
      ++forgotten;
    }
    if (forgotten == 0 && choices_.again != "failed") {
      throw InputError("No case is named '" + choices_.again + "'",
                       "See the names by --list, or write failed or all");
    }
  }

  template <class Known>
  std::vector<sweep::OpenCase> open_cases(const ResultStore& store, const Known& others,
                                          const Part* part) const {
    std::unique_ptr<ResultStore> earlier;
    if (!choices_.costs.empty()) {
      earlier = std::make_unique<ResultStore>(fs::path(choices_.costs) / "results.db",
                                              text::DatabaseUse::kRead);
    }
    std::vector<sweep::OpenCase> open;
    for (std::int64_t i = 0; i < cases_.size(); ++i) {
      if (part && !part->has(i)) continue;
      if (!choices_.again.empty() && !std::binary_search(again_.begin(), again_.end(), i)) continue;
      const std::string name = cases_.at(i).name;
      if (!is_chosen(name) || store.has(name) || others.has(name)) continue;
      std::optional<double> seconds = store.seconds(name);
      if (!seconds && earlier) seconds = earlier->seconds(name);
      open.push_back({i, seconds});
    }
    return open;
  }

  std::unique_ptr<Workers> workers_for(std::int64_t cases) const {
    const int asked = choices_.workers > 0 ? choices_.workers
                                           : static_cast<int>(std::thread::hardware_concurrency());
    return sweep::workers_here(static_cast<int>(std::min<std::int64_t>(std::max(1, asked), cases)),
                               sweep::run_program);
  }

  template <class Known>
  int run_open(ResultStore& store, const Known& others, const Part* part) {
    sweep::Handout handout(open_cases(store, others, part));
    if (handout.total() == 0) return nothing_open(store, part);
    std::unique_ptr<Workers> here;
    if (!ranks_) here = workers_for(handout.total());
    sweep::SaidProgress said;
    const RunProgress progress = sweep::run_cases(
        handout, ranks_ ? *ranks_ : *here, store, [this](std::int64_t i) { return order(i); },
        [&](const RunProgress& now) { said.say(now); });
    said.end();
    sweep::print_summary(progress);
    if (progress.failed > 0) {
      print_status(
          cases_, [&](const std::string& name) { return store.find(name); }, command());
    }
    if (!progress.is_stopped) return progress.failed > 0 ? 1 : 0;
    fmt::print("Stopped. What ended is kept; start it again to go on\n");
    return 130;
  }

  // What failed was a failure before, and still is.
  int nothing_open(ResultStore& store, const Part* part) const {
    for (std::int64_t i = 0; i < cases_.size(); ++i) {
      const std::string name = cases_.at(i).name;
      if ((part && !part->has(i)) || !is_chosen(name)) continue;
      const auto known = store.find(name);
      if (!known || !known->failed()) continue;
      fmt::print("Nothing is open, and not each case has a result\n");
      print_status(
          cases_, [&](const std::string& one) { return store.find(one); }, command());
      return 1;
    }
    fmt::print("Nothing is open: each case has its result\n");
    return 0;
  }

  CaseOrder order(std::int64_t index) const {
    const Case one = cases_.at(index);
    CaseOrder order{index,
                    one.name,
                    {program_},
                    folder_->case_folder(one.name).string(),
                    description_.results,
                    description_.timeout,
                    description_.keep};
    const auto arguments = cases_.arguments(one, order.folder);
    order.words.insert(order.words.end(), arguments.begin(), arguments.end());
    return order;
  }

  std::string command() const {
    return fmt::format("prehend sweep {} --out {}", choices_.file, choices_.out);
  }

  void write_array() const {
    const fs::path script = folder_->path() / "array.sh", logs = folder_->path() / "logs";
    std::vector<std::string> words{fs::absolute(choices_.file).string(),
                                   "--out=" + folder_->path().string()};
    if (!choices_.only.empty()) words.push_back("--only=" + choices_.only);
    if (!choices_.costs.empty())
      words.push_back("--costs=" + fs::absolute(choices_.costs).string());
    fs::create_directories(logs);
    sweep::write_text(script, [&](std::ostream& out) {
      out << slurm_array(choices_.slurm, fs::path(choices_.file).stem().string(), words, logs);
    });
    fmt::print(
        "Submit it:      sbatch {}\n"
        "Follow it:      {} --status\n"
        "At its end:     {} --merge --export results.csv\n"
        "Submit it again to go on where it was cancelled\n",
        script.string(), command(), command());
  }

  void export_tables(
      const sweep::FindResult& find,
      const std::function<std::optional<double>(const std::string&)>& seconds) const {
    if (!choices_.export_file.empty()) {
      const fs::path file = choices_.export_file;
      const sweep::ResultTable table(description_, cases_, find);
      if (file.extension() == ".csv") {
        sweep::write_csv(table, file);
      } else {
        write_hdf5(table, fs::path(choices_.file).filename().string(), file);
      }
      fmt::print("{}: {} rows{}\n", file.string(), table.rows(),
                 table.missing() > 0 ? fmt::format("; {} cases have no result yet and are left out",
                                                   table.missing())
                                     : "");
    }
    if (!choices_.export_costs.empty()) sweep::write_costs(cases_, seconds, choices_.export_costs);
  }

  const SweepChoices& choices_;
  Workers* const ranks_;
  const sweep::Description description_;
  const Cases cases_;
  const std::string program_;
  std::unique_ptr<SweepFolder> folder_;
  std::vector<std::int64_t> again_;  // sorted
};

}  // namespace

int run_sweep(const SweepChoices& choices) {
  if (!choices.mpi) return Sweep(choices, nullptr).run();
  return sweep::hand_out_to_ranks(choices.lost_after, sweep::run_program,
                                  [&](Workers& ranks) { return Sweep(choices, &ranks).run(); });
}

}  // namespace prehend::tools
