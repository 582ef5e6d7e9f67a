#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "prehend/sweep/cases.h"
#include "prehend/sweep/results.h"

namespace prehend::sweep {

/// Where a case's result is looked for.
using FindResult = std::function<std::optional<CaseResult>(const std::string& name)>;

/// What a column's values are; empty ones are none of it.
enum class ColumnKind {
  kWhole,   ///< all are whole numbers of at most 15 digits and none is empty
  kNumber,  ///< all are numbers; empty ones mean that there is none
  kText,    ///< others, and columns in which nothing stands
};

struct Column {
  std::string name;
  ColumnKind kind = ColumnKind::kWhole;
};

/// All results as one table: a row for each row of each case, in the order of the description. It
/// holds nothing of when, where or how long a case ran, so that it is the same, byte by byte,
/// whoever ran it. Columns: case, the parameters, state ("done", "failed"), problem, then what the
/// cases have, in the order in which they have it first; `result.X` where a parameter has the name.
class ResultTable {
 public:
  /// Goes through all results once; all must outlive it.
  ResultTable(const Description& description, const Cases& cases, FindResult find);

  const std::vector<Column>& columns() const { return columns_; }
  std::int64_t rows() const { return rows_; }
  std::int64_t failed() const { return failed_; }
  /// Cases without a result, which have no row.
  std::int64_t missing() const { return missing_; }

  /// Goes through them once more.
  void for_each_row(const std::function<void(const std::vector<std::string>&)>& use) const;

 private:
  void visit(const std::function<void(const Case&, const CaseResult&)>& use) const;
  std::string column_of(const std::string& result) const;

  const Description& description_;
  const Cases& cases_;
  FindResult find_;
  std::vector<Column> columns_;
  std::int64_t rows_ = 0, failed_ = 0, missing_ = 0;
};

/// As RFC 4180 has it, whole or not at all. @throws InputError when it cannot be written.
void write_csv(const ResultTable& table, const std::filesystem::path& file);

/// What each case took: case, seconds. @throws InputError as write_csv().
void write_costs(const Cases& cases,
                 const std::function<std::optional<double>(const std::string& name)>& seconds,
                 const std::filesystem::path& file);

/// The same of any text.
void write_text(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write);

/// Lets `write` make FILE.part, which then becomes `file`, or goes. @throws InputError when that
/// fails, and what `write` throws.
void write_whole(const std::filesystem::path& file,
                 const std::function<void(const std::filesystem::path&)>& write);

}  // namespace prehend::sweep
