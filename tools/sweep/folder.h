#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "prehend/sweep/results.h"
#include "prehend/sweep/workers/folder_lock.h"

namespace prehend::tools {

/// "3/8": part 3 of 8.
struct Part {
  int number = 0, of = 0;
  /// @throws InputError
  static Part parse(const std::string& text);
  bool has(std::int64_t index) const { return index % of == number - 1; }
};

/// Where a sweep keeps what:
///   results.db          results of whole runs and of merged parts
///   parts/3-of-8.db     results of a part that is not merged yet
///   cases/NAME/         what a case wrote, its output.txt
///   array.sh, logs/     the Slurm array and what its parts print
class SweepFolder {
 public:
  /// @throws InputError when it cannot be made.
  explicit SweepFolder(const std::filesystem::path& folder);

  const std::filesystem::path& path() const { return folder_; }
  std::filesystem::path results() const { return folder_ / "results.db"; }
  std::filesystem::path part(const Part& part) const;
  std::filesystem::path case_folder(const std::string& name) const;
  /// Parts' results that are there, sorted; without those of `except`.
  std::vector<std::filesystem::path> parts(const std::filesystem::path& except = {}) const;

  /// The folder for one process that may change all of it. @throws InputError as sweep::FolderLock.
  std::unique_ptr<sweep::FolderLock> lock_whole() const;
  /// A part's share of it; the second is the part's own.
  std::pair<std::unique_ptr<sweep::FolderLock>, std::unique_ptr<sweep::FolderLock>> lock_part(
      const Part& part) const;

  /// Takes what parts have into `store` and removes their files. How many there were.
  /// @pre The whole is locked.
  int merge_into(sweep::ResultStore& store) const;

 private:
  std::filesystem::path folder_;
};

/// All results of a folder for those who only look, merged or not.
class FolderResults {
 public:
  /// Without the results of `except`, a part's file.
  explicit FolderResults(const SweepFolder& folder, const std::filesystem::path& except = {});

  bool has(const std::string& name) const;
  std::optional<sweep::CaseResult> find(const std::string& name) const;
  std::optional<double> seconds(const std::string& name) const;
  /// @throws InputError as ResultStore::bind_to(), without noting anything.
  void check(const sweep::Description& description) const;

 private:
  std::vector<std::unique_ptr<sweep::ResultStore>> stores_;
};

}  // namespace prehend::tools
