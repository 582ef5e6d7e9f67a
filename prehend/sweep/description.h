#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "prehend/sweep/values.h"

namespace prehend::sweep {

/// Where a case's figures are found once its program ended.
struct ResultSource {
  enum class Kind { kNone, kCsv, kJson, kText, kOutput };
  Kind kind = Kind::kNone;
  std::string file;  // kCsv, kJson, kText: in the case's folder
  /// kOutput: column and regular expression (ECMAScript) with one group; the last match counts.
  std::vector<std::pair<std::string, std::string>> patterns;
};

struct GridParameter {
  std::string name;
  Values values;
};

struct SampledParameter {
  std::string name;
  Distribution distribution;
};

/// Independent runs of one program: every combination of the grid's values with every draw of the
/// sample.
struct Description {
  std::filesystem::path file;
  std::string program;                 // as written
  std::vector<std::string> arguments;  // with {name}, {folder}, {case}; {{ and }} are braces
  std::vector<GridParameter> grid;     // the last one changes fastest
  std::vector<SampledParameter> sampled;
  std::int64_t sample_count = 0;
  std::uint64_t sample_seed = 1;
  ResultSource results;
  double timeout = 0;  // s; 0: none
  bool keep = true;    // the folders of cases that ended well

  /// What a case's result depends on beside the values in its name, by its key in the file.
  std::map<std::string, std::string> fixed;
};

/// Lines that a program prints, for `lines_of`. Gets its words.
using LinesOf = std::function<std::vector<std::string>(const std::vector<std::string>&)>;

constexpr std::int64_t kMostCases = 10'000'000;

/// Reads the description; docs/sweeps.md explains each key. @throws InputError that names the file
/// for unknown keys and placeholders, parameters that no argument uses, empty grids, more than
/// kMostCases.
Description read_description(const std::filesystem::path& file, const LinesOf& lines_of);

}  // namespace prehend::sweep
