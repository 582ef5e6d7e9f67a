#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "prehend/sweep/description.h"
#include "prehend/text/database.h"

namespace prehend::sweep {

/// Figures of one case.
struct Rows {
  std::vector<std::string> names;              // of the columns
  std::vector<std::vector<std::string>> rows;  // each as long as `names`
};

/// What became of a case.
struct CaseResult {
  std::string name;
  std::string problem;  // why it failed; empty: it is done
  std::string output;   // of a failed one: the last lines that it printed
  Rows rows;
  double seconds = 0;  // that it took
  std::string worker;  // where: host and process

  bool failed() const { return !problem.empty(); }
};

/// The results of a sweep in one SQLite file: the table `result` has a row a case, `cost` what they
/// took, `description` what they depend on. One process writes, others may read.
class ResultStore {
 public:
  /// @throws InputError when it is no such file, or, for kRead, is not there.
  explicit ResultStore(const std::filesystem::path& file,
                       text::DatabaseUse use = text::DatabaseUse::kChange);

  /// Whether all of `fixed` is noted, by its keys.
  bool agrees_with(const std::map<std::string, std::string>& fixed) const;
  /// Forgets all results and notes `fixed`; costs stay.
  void begin_anew(const std::map<std::string, std::string>& fixed);

  /// Results of other arguments are never mixed. @throws InputError naming the first thing that
  /// `description` fixes otherwise than what is noted.
  void check(const Description& description) const;
  /// The same, then notes what is not yet noted.
  void bind_to(const Description& description);

  bool has(const std::string& name) const;
  std::optional<CaseResult> find(const std::string& name) const;
  /// [s] that the case took when it last ran, also of results that were forgotten.
  std::optional<double> seconds(const std::string& name) const;
  struct Counts {
    std::int64_t done = 0, failed = 0;
  };
  Counts counts() const;
  /// Names, sorted.
  std::vector<std::string> failed() const;

  /// All of them or, when the process ends in it, none. What was there of these cases is replaced.
  void add(const std::vector<CaseResult>& results);
  /// That the case runs again; its cost stays.
  void forget(const std::string& name);
  /// All that `other` has.
  void take_from(const ResultStore& other);

 private:
  void note(const std::map<std::string, std::string>& fixed);
  std::optional<std::string> noted(const std::string& key) const;

  text::Database database_;
  mutable text::Database::Statement has_, find_, seconds_;
};

}  // namespace prehend::sweep
