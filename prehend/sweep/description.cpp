#include "prehend/sweep/description.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <regex>
#include <set>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "prehend/sweep/cases.h"
#include "prehend/text/input_error.h"
#include "prehend/text/json.h"
#include "prehend/text/nearest_match.h"
#include "prehend/text/quantities.h"
#include "prehend/text/yaml_map.h"

namespace prehend::sweep {
namespace {

using text::InputError;
using text::YamlMap;

// Columns of the export and placeholders that are there already.
const std::set<std::string> kTaken{"case", "folder", "sample", "state", "problem"};

class Reader {
 public:
  Reader(const std::filesystem::path& file, const LinesOf& lines_of)
      : lines_of_(lines_of), top_(text::load_yaml_map(file), file, "the sweep") {
    made_.file = file;
  }

  Description read() {
    top_.read("program", made_.program);
    if (made_.program.empty()) top_.fail("program", "is missing", "Name the program to run");
    read_arguments();
    read_grid();
    read_sample();
    read_results();
    read_timeout();
    std::string keep = "all";
    top_.read("keep", keep);
    if (keep != "all" && keep != "failed") {
      top_.fail("keep", "is '" + keep + "'", "Write all or failed");
    }
    made_.keep = keep == "all";
    top_.finish();
    check_names();
    check_size();
    return std::move(made_);
  }

 private:
  std::vector<std::string> words(YamlMap& map, const std::string& key) const {
    const YAML::Node node = map.child(key);
    if (!node.IsDefined()) return {};
    if (!node.IsSequence()) map.fail(key, "is no list", "Write [a, b]");
    std::vector<std::string> read;
    for (const YAML::Node& entry : node) {
      if (!entry.IsScalar()) map.fail(key, "has an entry that is no word", "Write [a, b]");
      read.push_back(entry.Scalar());
    }
    return read;
  }

  void read_arguments() {
    made_.arguments = words(top_, "arguments");
    made_.fixed["program"] = made_.program;
    made_.fixed["arguments"] = text::Json(made_.arguments).text();
  }

  // Calls `read`; what it finds wrong is said of `key`.
  template <class Read>
  void at(YamlMap& map, const std::string& key, Read read) const {
    try {
      read();
    } catch (const InputError& error) {
      const std::string all = error.what(), mend = all.substr(error.problem().size() + 2);
      map.fail(key, "is refused: " + error.problem(), mend.substr(0, mend.size() - 1));
    }
  }

  void read_grid() {
    const YAML::Node node = top_.child("grid");
    if (!node.IsDefined()) return;
    YamlMap grid(node, made_.file, "grid");
    if (node.size() == 0) top_.fail("grid", "is empty", "Write `name: [values]` lines");
    for (const auto& entry : node) {
      const std::string name = entry.first.Scalar();
      const YAML::Node value = grid.child(name);
      std::optional<Values> values;
      if (value.IsMap()) {
        YamlMap range(value, made_.file, "grid." + name);
        at(grid, name, [&] { values = read_range(range); });
        range.finish();
      } else {
        at(grid, name, [&] {
          values = Values::list(value.IsScalar() ? std::vector<std::string>{value.Scalar()}
                                                 : words(grid, name));
        });
      }
      made_.grid.push_back({name, std::move(*values)});
    }
    grid.finish();
  }

  Values read_range(YamlMap& range) const {
    if (range.child("lines_of").IsDefined()) {
      const std::vector<std::string> command = words(range, "lines_of");
      if (command.empty()) range.fail("lines_of", "is empty", "Write [program, argument]");
      return Values::list(lines_of_(command));
    }
    std::string from, to, step = "1", spacing = "equal";
    int count = 0;
    range.read("from", from);
    range.read("to", to);
    const bool counts = range.child("count").IsDefined();
    if (from.empty() || to.empty()) {
      throw InputError("It has no from and to",
                       "Write [values], {from, to, step}, {from, to, count} or {lines_of}");
    }
    if (!counts) {
      range.read("step", step);
      return Values::steps(from, to, step);
    }
    range.read("count", count);
    range.read("spacing", spacing);
    if (spacing != "equal" && spacing != "log") {
      range.fail("spacing", "is '" + spacing + "'", "Write equal or log");
    }
    return Values::spread(Decimal::parse(from).value(), Decimal::parse(to).value(), count,
                          spacing == "log");
  }

  void read_sample() {
    const YAML::Node node = top_.child("sample");
    if (!node.IsDefined()) return;
    YamlMap sample(node, made_.file, "sample");
    int count = 0;
    std::uint32_t seed = 1;
    sample.read("count", count);
    sample.read("seed", seed);
    if (count < 1) sample.fail("count", "must be at least 1", "Write how often to draw");
    made_.sample_count = count;
    made_.sample_seed = seed;
    std::string& fixed = made_.fixed["sample"];
    fixed = fmt::format("seed {}", seed);
    for (const auto& entry : node) {
      const std::string name = entry.first.Scalar();
      if (name == "count" || name == "seed") continue;
      const YAML::Node value = sample.child(name);
      YamlMap distribution(value, made_.file, "sample." + name);
      fixed += "; " + name;
      at(sample, name, [&] {
        made_.sampled.push_back({name, read_distribution(distribution, &fixed)});
      });
      distribution.finish();
    }
    sample.finish();
    if (made_.sampled.empty()) {
      top_.fail("sample", "draws nothing", "Write `name: {uniform: [low, high]}` lines");
    }
  }

  Distribution read_distribution(YamlMap& map, std::string* fixed) const {
    using Kind = Distribution::Kind;
    static const std::vector<std::pair<std::string, Kind>> kKinds{
        {"uniform", Kind::kUniform},
        {"log_uniform", Kind::kLogUniform},
        {"normal", Kind::kNormal},
        {"integer", Kind::kInteger},
        {"choice", Kind::kChoice}};
    Distribution read;
    int found = 0;
    for (const auto& [name, kind] : kKinds) {
      if (!map.child(name).IsDefined()) continue;
      ++found;
      read.kind = kind;
      const std::vector<std::string> given = words(map, name);
      if (kind == Kind::kChoice) {
        Values::list(given);  // refuses none, and one that is there twice
        read.choices = given;
      } else {
        if (given.size() != 2) map.fail(name, "has not two numbers", "Write [a, b]");
        read.low = Decimal::parse(given[0]).value();
        read.high = Decimal::parse(given[1]).value();
      }
      *fixed += fmt::format(" {} [{}]", name, fmt::join(given, ", "));
    }
    if (found != 1) {
      throw InputError("It needs one distribution",
                       "Write one of uniform, log_uniform, normal, integer, choice");
    }
    check(read);
    return read;
  }

  static void check(const Distribution& read) {
    using Kind = Distribution::Kind;
    const bool ordered = read.kind == Kind::kNormal ? read.high >= 0 : read.low <= read.high;
    if (!ordered) throw InputError("Its second number is too small", "Write [low, high]");
    if (read.kind == Kind::kLogUniform && read.low <= 0) {
      throw InputError("log_uniform needs ends above 0", "Correct the first number");
    }
    const bool whole = std::floor(read.low) == read.low && std::floor(read.high) == read.high;
    if (read.kind == Kind::kInteger && !whole) {
      throw InputError("integer needs whole numbers", "Correct them");
    }
  }

  void read_results() {
    const YAML::Node node = top_.child("results");
    using Kind = ResultSource::Kind;
    if (!node.IsDefined()) {
      top_.fail("results", "is missing",
                "Write {csv: FILE}, {json: FILE}, {output: {column: 'PATTERN'}}, or none");
    }
    std::string& fixed = made_.fixed["results"];
    if (node.IsScalar() && node.Scalar() == "none") {
      fixed = "none";
      return;
    }
    YamlMap results(node, made_.file, "results");
    results.read("csv", made_.results.file);
    if (!made_.results.file.empty()) made_.results.kind = Kind::kCsv;
    std::string object_file, text_file;
    results.read("json", object_file);
    results.read("text", text_file);
    const YAML::Node output = results.child("output");
    results.finish();
    if (node.size() != 1)
      top_.fail("results", "must be one of csv, json, text, output", "Keep one");
    if (!object_file.empty()) made_.results = {Kind::kJson, object_file, {}};
    if (!text_file.empty()) made_.results = {Kind::kText, text_file, {}};
    fixed = made_.results.file;
    if (!made_.results.file.empty()) {
      const std::filesystem::path path = made_.results.file;
      if (path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end()) {
        top_.fail("results", "is outside of the case's folder", "Name a file below {folder}");
      }
      return;
    }
    if (!output.IsDefined()) top_.fail("results", "names no file", "Write {csv: FILE}");
    read_patterns(results, output, &fixed);
  }

  void read_patterns(YamlMap& results, const YAML::Node& output, std::string* fixed) {
    made_.results.kind = ResultSource::Kind::kOutput;
    YamlMap patterns(output, made_.file, "results.output");
    for (const auto& entry : output) {
      const std::string column = entry.first.Scalar();
      std::string pattern;
      patterns.read(column, pattern);
      try {
        if (std::regex(pattern).mark_count() != 1) {
          patterns.fail(column, "has not one group", "Put ( ) around what is to be the value");
        }
      } catch (const std::regex_error& error) {
        patterns.fail(column, std::string("is no regular expression: ") + error.what(),
                      "Correct it");
      }
      made_.results.patterns.emplace_back(column, pattern);
      *fixed += column + ": " + pattern + "\n";
    }
    if (made_.results.patterns.empty()) {
      results.fail("output", "is empty", "Write `column: 'PATTERN'` lines");
    }
  }

  void read_timeout() {
    std::string timeout;
    top_.read("timeout", timeout);
    if (timeout.empty()) return;
    at(top_, "timeout", [&] { made_.timeout = text::parse_seconds(timeout); });
  }

  void check_names() {
    static const std::regex kName("[A-Za-z_][A-Za-z0-9_]*");
    std::vector<std::string> names;
    const auto add = [&](const std::string& name, const std::string& where) {
      if (!std::regex_match(name, kName) || name.size() > 40 || kTaken.count(name) != 0) {
        top_.fail(where, "has a parameter '" + name + "'",
                  "Write letters, digits and _, at most 40; not case, folder, sample, state, "
                  "problem");
      }
      if (std::find(names.begin(), names.end(), name) != names.end()) {
        top_.fail(where, "has the parameter '" + name + "' that grid has", "Keep one");
      }
      names.push_back(name);
    };
    for (const GridParameter& parameter : made_.grid) add(parameter.name, "grid");
    for (const SampledParameter& parameter : made_.sampled) add(parameter.name, "sample");
    std::set<std::string> used;
    for (const std::string& argument : made_.arguments) {
      at(top_, "arguments", [&] {
        const std::vector<std::string> here = placeholders(argument);
        used.insert(here.begin(), here.end());
      });
    }
    for (const std::string& name : names) {
      if (used.count(name) != 0) continue;
      top_.fail("arguments", "use the parameter '" + name + "' nowhere",
                "Write {" + name + "} where the program is to get it");
    }
    names.insert(names.end(), {"folder", "case"});
    for (const std::string& name : used) {
      if (std::find(names.begin(), names.end(), name) != names.end()) continue;
      top_.fail("arguments", "have {" + name + "}, which is no parameter",
                text::nearest_match_mend(name, names));
    }
  }

  void check_size() {
    if (made_.grid.empty() && made_.sampled.empty()) {
      top_.fail("grid", "is missing, and sample, too", "Describe the cases by one of them");
    }
    std::int64_t cases = made_.sampled.empty() ? 1 : made_.sample_count;
    for (const GridParameter& parameter : made_.grid) {
      // At most 1e7 * 1e16: in range.
      if (cases <= kMostCases) {
        cases *= std::min<std::int64_t>(parameter.values.size(), kMostCases + 1);
      }
    }
    if (cases > kMostCases) {
      throw InputError(
          fmt::format("{} describes more than {} cases", made_.file.string(), kMostCases),
          "Take fewer values, or a sample");
    }
  }

  const LinesOf& lines_of_;
  Description made_;
  YamlMap top_;
};

}  // namespace

Description read_description(const std::filesystem::path& file, const LinesOf& lines_of) {
  return Reader(file, lines_of).read();
}

}  // namespace prehend::sweep
