#include "prehend/sweep/results.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "prehend/text/input_error.h"

namespace prehend::sweep {
namespace {

using nlohmann::json;
using Statement = text::Database::Statement;
using text::InputError;

// Rows are JSON, a list of lists whose first has the names, so that SQL can ask for them, too.
constexpr const char* kSchema = R"(
CREATE TABLE description(key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE result(name TEXT PRIMARY KEY, problem TEXT NOT NULL, output TEXT NOT NULL,
  rows TEXT NOT NULL);
CREATE INDEX failed_result ON result(name) WHERE problem <> '';
CREATE TABLE cost(name TEXT PRIMARY KEY, seconds REAL NOT NULL, worker TEXT NOT NULL);
)";

// No write-ahead log: it needs memory that hosts of a cluster do not share.
const text::DatabaseKind kResults{.holds = "results of a sweep",
                                  .application = 0x50524853,  // "PRHS"
                                  .version = 1,
                                  .schema = kSchema,
                                  .settings =
                                      "PRAGMA journal_mode=TRUNCATE; "
                                      "PRAGMA synchronous=FULL"};

std::string to_json(const Rows& rows) {
  json all = json::array({rows.names});
  for (const auto& row : rows.rows) all.push_back(row);
  // What is no UTF-8 gets U+FFFD in its place.
  return all.dump(-1, ' ', false, json::error_handler_t::replace);
}

Rows from_json(const std::string& text) {
  auto all = json::parse(text).get<std::vector<std::vector<std::string>>>();
  Rows rows;
  rows.names = std::move(all.at(0));
  rows.rows.assign(std::make_move_iterator(all.begin() + 1), std::make_move_iterator(all.end()));
  return rows;
}

}  // namespace

ResultStore::ResultStore(const std::filesystem::path& file, text::DatabaseUse use)
    : database_(file, kResults, use),
      has_(database_, "SELECT 1 FROM result WHERE name=?"),
      find_(database_, "SELECT problem, output, rows FROM result WHERE name=?"),
      seconds_(database_, "SELECT seconds FROM cost WHERE name=?") {}

std::optional<std::string> ResultStore::noted(const std::string& key) const {
  Statement known(database_, "SELECT value FROM description WHERE key=?");
  known.bind(key);
  return known.step() ? std::optional(known.text(0)) : std::nullopt;
}

void ResultStore::note(const std::map<std::string, std::string>& fixed) {
  for (const auto& [key, value] : fixed) {
    Statement add(database_, "INSERT OR IGNORE INTO description VALUES(?, ?)");
    add.bind(key).bind(value).step();
  }
}

bool ResultStore::agrees_with(const std::map<std::string, std::string>& fixed) const {
  return std::all_of(fixed.begin(), fixed.end(),
                     [&](const auto& one) { return noted(one.first) == one.second; });
}

void ResultStore::begin_anew(const std::map<std::string, std::string>& fixed) {
  database_.transaction([&] {
    Statement(database_, "DELETE FROM result").step();
    Statement(database_, "DELETE FROM description").step();
    note(fixed);
  });
}

void ResultStore::check(const Description& description) const {
  for (const auto& [key, value] : description.fixed) {
    const std::optional<std::string> known = noted(key);
    if (!known || *known == value) continue;
    throw InputError("'" + database_.file() + "' has results of other " + key + ": '" + *known +
                         "', but " + description.file.string() + " has '" + value + "'",
                     "Name another folder, or put that back");
  }
}

void ResultStore::bind_to(const Description& description) {
  check(description);
  database_.transaction([&] { note(description.fixed); });
}

bool ResultStore::has(const std::string& name) const {
  const bool there = has_.reset().bind(name).step();
  has_.reset();  // else it holds a lock that a writer waits for
  return there;
}

std::optional<CaseResult> ResultStore::find(const std::string& name) const {
  std::optional<CaseResult> found;
  if (find_.reset().bind(name).step()) {
    found.emplace();
    found->name = name;
    found->problem = find_.text(0);
    found->output = find_.text(1);
    found->rows = from_json(find_.text(2));
  }
  find_.reset();
  return found;
}

std::optional<double> ResultStore::seconds(const std::string& name) const {
  std::optional<double> found;
  if (seconds_.reset().bind(name).step()) found = seconds_.number(0);
  seconds_.reset();
  return found;
}

ResultStore::Counts ResultStore::counts() const {
  Statement all(database_, "SELECT count(*), coalesce(sum(problem <> ''), 0) FROM result");
  all.step();
  return {all.integer(0) - all.integer(1), all.integer(1)};
}

std::vector<std::string> ResultStore::failed() const {
  Statement rows(database_, "SELECT name FROM result WHERE problem <> '' ORDER BY name");
  std::vector<std::string> names;
  while (rows.step()) names.push_back(rows.text(0));
  return names;
}

void ResultStore::add(const std::vector<CaseResult>& results) {
  if (results.empty()) return;
  database_.transaction([&] {
    for (const CaseResult& result : results) {
      Statement add(database_, "INSERT OR REPLACE INTO result VALUES(?, ?, ?, ?)");
      add.bind(result.name).bind(result.problem).bind(result.output).bind(to_json(result.rows));
      add.step();
      Statement cost(database_, "INSERT OR REPLACE INTO cost VALUES(?, ?, ?)");
      cost.bind(result.name).bind(result.seconds).bind(result.worker).step();
    }
  });
}

void ResultStore::forget(const std::string& name) {
  Statement remove(database_, "DELETE FROM result WHERE name=?");
  remove.bind(name).step();
}

void ResultStore::take_from(const ResultStore& other) {
  database_.transaction([&] {
    Statement costs(other.database_, "SELECT name, seconds, worker FROM cost");
    while (costs.step()) {
      Statement cost(database_, "INSERT OR REPLACE INTO cost VALUES(?, ?, ?)");
      cost.bind(costs.text(0)).bind(costs.number(1)).bind(costs.text(2)).step();
    }
    Statement rows(other.database_, "SELECT name, problem, output, rows FROM result");
    while (rows.step()) {
      Statement add(database_, "INSERT OR REPLACE INTO result VALUES(?, ?, ?, ?)");
      add.bind(rows.text(0)).bind(rows.text(1)).bind(rows.text(2)).bind(rows.text(3)).step();
    }
  });
}

}  // namespace prehend::sweep
