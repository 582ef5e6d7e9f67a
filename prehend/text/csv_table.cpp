#include "prehend/text/csv_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>

#include <fmt/format.h>

#include "prehend/text/input_error.h"
#include "prehend/text/nearest_match.h"

namespace prehend::text {
namespace {

// A line's fields; quoted ones as RFC 4180 has them, without line breaks.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += line[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else if (c != '\r') {
      fields.back() += c;
    }
  }
  return fields;
}

}  // namespace

int CsvTable::index(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

int CsvTable::require(const std::string& name, const std::string& meaning) const {
  const int column = index(name);
  if (column >= 0) return column;
  throw InputError(
      fmt::format("{} has no column '{}'{}", file.string(), name, nearest_match_hint(name, names)),
      "Add it: " + meaning);
}

std::vector<double> CsvTable::numbers(int column, double scale) const {
  std::vector<double> values;
  values.reserve(rows.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::string& text = rows[r][static_cast<std::size_t>(column)];
    std::size_t begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
    double value = std::nan("");
    if (begin != std::string::npos) {
      if (text[begin] == '+') ++begin;
      const char* last = text.data() + end + 1;
      const auto read = std::from_chars(text.data() + begin, last, value);
      if (read.ec != std::errc() || read.ptr != last) value = std::nan("");
    }
    if (!std::isfinite(value)) {
      throw InputError(fmt::format("{}:{}: {} is '{}', no finite number", file.string(), lines[r],
                                   names[static_cast<std::size_t>(column)], text),
                       "Leave out rows that were not measured");
    }
    values.push_back(scale * value);
  }
  return values;
}

CsvTable read_csv_table(const std::filesystem::path& file, std::size_t least,
                        const std::string& mend) {
  std::ifstream in(file);
  if (!in || std::filesystem::is_directory(file)) {
    throw InputError(file.string() + " cannot be read", "Check the path");
  }
  CsvTable table;
  table.file = file;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.empty() || line == "\r" || line[0] == '#') continue;
    std::vector<std::string> fields = fields_of(line);
    if (table.names.empty()) {
      table.names = std::move(fields);
      continue;
    }
    if (fields.size() != table.names.size()) {
      throw InputError(fmt::format("{}:{} has {} fields for {} columns", file.string(), number,
                                   fields.size(), table.names.size()),
                       "Give each row as many as the line of names");
    }
    table.rows.push_back(std::move(fields));
    table.lines.push_back(number);
  }
  if (table.rows.size() < least) {
    throw InputError(
        fmt::format("{} holds fewer than {} rows under its line of names", file.string(), least),
        mend);
  }
  return table;
}

}  // namespace prehend::text
