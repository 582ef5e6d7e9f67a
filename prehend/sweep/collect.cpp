#include "prehend/sweep/collect.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>

#include <nlohmann/json.hpp>

#include "prehend/text/csv_table.h"
#include "prehend/text/input_error.h"

namespace prehend::sweep {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using text::InputError;

constexpr std::size_t kLastLines = 20;
constexpr std::streamoff kLastBytes = 4096;
constexpr std::size_t kLongestLine = 4096;  // that patterns are tried on: std::regex recurses

void refuse_missing(const fs::path& file) {
  if (!fs::is_regular_file(file)) {
    throw InputError("It wrote no " + file.filename().string(),
                     "Look at what it printed, and that results names its file");
  }
}

Rows from_csv(const fs::path& file) {
  text::CsvTable table;
  try {
    table = text::read_csv_table(file, 0, "");
  } catch (const InputError& error) {
    // Results are the same wherever their folder is.
    std::string problem = error.problem();
    const std::size_t at = problem.find(file.string());
    if (at != std::string::npos) {
      problem.replace(at, file.string().size(), file.filename().string());
    }
    throw InputError(problem, "Give each row as many fields as the line of names");
  }
  std::set<std::string> names(table.names.begin(), table.names.end());
  if (names.empty() || names.size() != table.names.size()) {
    throw InputError(file.filename().string() + " has no names of columns, or one twice",
                     "Give each column a name of its own in the first line");
  }
  return {std::move(table.names), std::move(table.rows)};
}

std::string text_of(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  return value.is_null() ? "" : value.dump();
}

// What is nested gets names such as hand.force; lists stay JSON.
void flatten(const json& object, const std::string& before, Rows* rows) {
  for (const auto& [key, value] : object.items()) {
    if (value.is_object()) {
      flatten(value, before + key + ".", rows);
    } else {
      rows->names.push_back(before + key);
      rows->rows.front().push_back(text_of(value));
    }
  }
}

Rows from_json_file(const fs::path& file) {
  std::ifstream in(file);
  const json read = json::parse(in, nullptr, false);
  if (!read.is_object()) {
    throw InputError(file.filename().string() + " is no JSON object",
                     "Let the program write {\"name\": value}");
  }
  Rows rows{{}, {{}}};
  flatten(read, "", &rows);
  return rows;
}

// One value.
Rows from_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {{"text"}, {{std::string(std::istreambuf_iterator<char>(in), {})}}};
}

Rows from_output(const ResultSource& source, const fs::path& output) {
  std::vector<std::regex> patterns;
  Rows rows{{}, {{}}};
  for (const auto& [column, pattern] : source.patterns) {
    rows.names.push_back(column);
    patterns.emplace_back(pattern);
  }
  std::vector<bool> found(patterns.size());
  rows.rows.front().resize(patterns.size());
  std::ifstream in(output);
  std::string line;
  bool printed = false;
  while (std::getline(in, line)) {
    printed = true;
    if (line.size() > kLongestLine) line.resize(kLongestLine);
    for (std::size_t i = 0; i < patterns.size(); ++i) {
      std::smatch match;
      if (!std::regex_search(line, match, patterns[i])) continue;
      found[i] = true;
      rows.rows.front()[i] = match[1];
    }
  }
  const auto missing = std::find(found.begin(), found.end(), false);
  if (!printed) throw InputError("It printed nothing", "Look why");
  if (missing != found.end()) {
    const auto& [column, pattern] =
        source.patterns[static_cast<std::size_t>(missing - found.begin())];
    throw InputError("It printed no " + column + ", '" + pattern + "'",
                     "Look at what it printed, and at the pattern");
  }
  return rows;
}

}  // namespace

Rows collect(const ResultSource& source, const fs::path& folder, const fs::path& output) {
  const fs::path file = folder / source.file;
  switch (source.kind) {
    case ResultSource::Kind::kNone:
      return {};
    case ResultSource::Kind::kCsv:
      refuse_missing(file);
      return from_csv(file);
    case ResultSource::Kind::kJson:
      refuse_missing(file);
      return from_json_file(file);
    case ResultSource::Kind::kText:
      refuse_missing(file);
      return from_text(file);
    case ResultSource::Kind::kOutput:
      return from_output(source, output);
  }
  return {};
}

std::string last_lines(const fs::path& file) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) return "";
  const std::streamoff size = in.tellg(), from = std::max<std::streamoff>(0, size - kLastBytes);
  in.seekg(from);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  std::string last;
  const std::size_t begin = lines.size() - std::min(lines.size(), kLastLines);
  for (std::size_t i = begin; i < lines.size(); ++i) last += lines[i] + "\n";
  return last;
}

}  // namespace prehend::sweep
