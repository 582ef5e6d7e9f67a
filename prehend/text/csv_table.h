#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace prehend::text {

/// The columns of a CSV file, with the line of each row for errors.
struct CsvTable {
  std::filesystem::path file;
  std::vector<std::string> names;
  std::vector<std::vector<std::string>> rows;  // each as long as `names`
  std::vector<int> lines;                      // of the rows

  /// Of the column; -1 when there is none of that name.
  int index(const std::string& name) const;
  /// The same, but @throws InputError naming the nearest when there is none; `meaning` says what it
  /// is to hold.
  int require(const std::string& name, const std::string& meaning) const;
  /// The column's values times `scale`. @throws InputError "file:line: ..." for one that is no
  /// finite number. @pre 0 <= column < names.size()
  std::vector<double> numbers(int column, double scale = 1) const;
};

/// Reads CSV (RFC 4180, without line breaks in fields) with a line of names first; empty lines and
/// those that begin with # are left out.
/// @throws InputError for a file that cannot be read, rows of another length than the names, fewer
/// rows than `least` (its mend is `mend`).
CsvTable read_csv_table(const std::filesystem::path& file, std::size_t least,
                        const std::string& mend);

}  // namespace prehend::text
