#include "prehend/sweep/table.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>

#include "prehend/text/input_error.h"

namespace prehend::sweep {
namespace {

namespace fs = std::filesystem;
using text::InputError;

constexpr std::size_t kWholeDigits = 15;  // a double has them, too

ColumnKind kind_of(const std::string& value) {
  if (value.empty()) return ColumnKind::kNumber;
  const std::size_t sign = value[0] == '-' ? 1 : 0;
  const bool digits = std::all_of(value.begin() + static_cast<std::ptrdiff_t>(sign), value.end(),
                                  [](unsigned char c) { return std::isdigit(c) != 0; });
  if (digits && value.size() > sign && value.size() - sign <= kWholeDigits) {
    return ColumnKind::kWhole;
  }
  double number = 0;
  const auto read = std::from_chars(value.data(), value.data() + value.size(), number);
  return read.ec == std::errc() && read.ptr == value.data() + value.size() ? ColumnKind::kNumber
                                                                           : ColumnKind::kText;
}

std::string csv_field(const std::string& value) {
  if (value.find_first_of(",\"\r\n") == std::string::npos) return value;
  std::string quoted = "\"";
  for (const char c : value) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

std::string csv_line(const std::vector<std::string>& values) {
  std::string line;
  for (const std::string& value : values) line += csv_field(value) + ",";
  line.back() = '\r';
  return line + "\n";
}

}  // namespace

ResultTable::ResultTable(const Description& description, const Cases& cases, FindResult find)
    : description_(description), cases_(cases), find_(std::move(find)) {
  columns_.push_back({"case"});
  for (const GridParameter& one : description.grid) columns_.push_back({one.name});
  for (const SampledParameter& one : description.sampled) columns_.push_back({one.name});
  columns_.push_back({"state"});
  columns_.push_back({"problem"});
  missing_ = cases.size();
  visit([this](const Case&, const CaseResult& result) {
    --missing_;
    rows_ += std::max<std::int64_t>(1, static_cast<std::int64_t>(result.rows.rows.size()));
    failed_ += result.failed() ? 1 : 0;
    for (const std::string& name : result.rows.names) {
      const std::string column = column_of(name);
      const bool known = std::any_of(columns_.begin(), columns_.end(),
                                     [&](const Column& one) { return one.name == column; });
      if (!known) columns_.push_back({column});
    }
  });
  std::vector<bool> has_value(columns_.size());
  for_each_row([&](const std::vector<std::string>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      columns_[i].kind = std::max(columns_[i].kind, kind_of(row[i]));
      has_value[i] = has_value[i] || !row[i].empty();
    }
  });
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (!has_value[i]) columns_[i].kind = ColumnKind::kText;
  }
}

std::string ResultTable::column_of(const std::string& result) const {
  const std::size_t own = 3 + description_.grid.size() + description_.sampled.size();
  const bool taken =
      std::any_of(columns_.begin(), columns_.begin() + static_cast<std::ptrdiff_t>(own),
                  [&](const Column& one) { return one.name == result; });
  return taken ? "result." + result : result;
}

void ResultTable::visit(const std::function<void(const Case&, const CaseResult&)>& use) const {
  for (std::int64_t i = 0; i < cases_.size(); ++i) {
    const Case one = cases_.at(i);
    if (const std::optional<CaseResult> result = find_(one.name)) use(one, *result);
  }
}

void ResultTable::for_each_row(
    const std::function<void(const std::vector<std::string>&)>& use) const {
  std::map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < columns_.size(); ++i) places[columns_[i].name] = i;
  visit([&](const Case& one, const CaseResult& result) {
    std::vector<std::string> row(columns_.size());
    row[0] = one.name;
    for (std::size_t i = 0; i < one.values.size(); ++i) row[1 + i] = one.values[i].second;
    row[1 + one.values.size()] = result.failed() ? "failed" : "done";
    row[2 + one.values.size()] = result.problem;
    if (result.rows.rows.empty()) use(row);
    for (const auto& values : result.rows.rows) {
      for (std::size_t i = 0; i < values.size(); ++i) {
        row[places.at(column_of(result.rows.names[i]))] = values[i];
      }
      use(row);
    }
  });
}

void write_whole(const fs::path& file, const std::function<void(const fs::path&)>& write) {
  fs::path part = file;
  part += ".part";
  std::error_code error;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), error);
  std::error_code ignored;
  try {
    write(part);
  } catch (...) {
    fs::remove(part, ignored);
    throw;
  }
  fs::rename(part, file, error);
  if (error) {
    fs::remove(part, ignored);
    throw InputError("'" + file.string() + "' cannot be written: " + error.message(),
                     "Name another file");
  }
}

void write_text(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  write_whole(file, [&](const fs::path& part) {
    std::ofstream out(part, std::ios::binary);
    write(out);
    if (!out.flush()) {
      throw InputError("'" + part.string() + "' cannot be written",
                       "Check its folder and the space there");
    }
  });
}

void write_costs(const Cases& cases,
                 const std::function<std::optional<double>(const std::string& name)>& seconds,
                 const fs::path& file) {
  write_text(file, [&](std::ostream& out) {
    out << csv_line({"case", "seconds"});
    for (std::int64_t i = 0; i < cases.size(); ++i) {
      const std::string name = cases.at(i).name;
      if (const auto took = seconds(name)) out << csv_line({name, number_text(*took)});
    }
  });
}

void write_csv(const ResultTable& table, const fs::path& file) {
  write_text(file, [&](std::ostream& out) {
    std::vector<std::string> names;
    for (const Column& column : table.columns()) names.push_back(column.name);
    out << csv_line(names);
    table.for_each_row([&](const std::vector<std::string>& row) { out << csv_line(row); });
  });
}

}  // namespace prehend::sweep
