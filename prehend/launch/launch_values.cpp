#include "prehend/launch/launch_values.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "prehend/graph/parameter_list.h"
#include "prehend/text/nearest_match.h"

namespace prehend::launch {
namespace {

constexpr std::size_t kLongestText = 64 * 1024;

std::string trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return "";
  return std::string(text.substr(begin, text.find_last_not_of(" \t") - begin + 1));
}

std::string unquoted(const std::string& text) {
  const bool quoted = text.size() >= 2 && (text.front() == '\'' || text.front() == '"') &&
                      text.back() == text.front();
  return quoted ? text.substr(1, text.size() - 2) : text;
}

std::optional<bool> truth_of(const std::string& text) {
  if (text == "true" || text == "True" || text == "yes" || text == "on" || text == "1") return true;
  if (text == "false" || text == "False" || text == "no" || text == "off" || text == "0") {
    return false;
  }
  return std::nullopt;
}

bool is_list(const std::string& text) {
  try {
    graph::split_list(text);
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

template <class Number>
bool is_number(const std::string& text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

void add_entries(const LaunchScope& scope, const YAML::Node& node, const std::string& what,
                 const std::string& prefix, Values values,
                 std::map<std::string, std::string>& entries,
                 std::map<std::string, std::string>* places) {
  if (!node.IsMap()) fail(scope, node, what + " must be a mapping of names to values");
  for (const auto& entry : node) {
    const std::string key = prefix + entry.first.Scalar();
    if (entry.second.IsMap()) {
      add_entries(scope, entry.second, what, key + ".", values, entries, places);
    } else {
      const std::string value = values == Values::kSingleOrLists
                                    ? value_text_of(scope, entry.second, what + " " + key)
                                    : text_of(scope, entry.second, what + " " + key);
      if (!entries.emplace(key, value).second) {
        fail(scope, entry.first, what + " gives " + key + " twice");
      }
      if (places) places->emplace(key, place_of(scope, entry.first));
    }
  }
}

}  // namespace

bool is_open(const std::string& text) { return text.find("$(") != std::string::npos; }

std::string short_path(const std::string& path) {
  std::error_code error;
  const std::string from_here = std::filesystem::proximate(path, error).string();
  return error || from_here.size() > path.size() ? path : from_here;
}

std::string place_of(const LaunchScope& scope, const YAML::Node& node) {
  return short_path(scope.file) + ":" + std::to_string(node.Mark().line + 1);
}

void fail(const LaunchScope& scope, const YAML::Node& node, const std::string& text) {
  throw LaunchError(place_of(scope, node) + ": " + text);
}

void check_keys(const LaunchScope& scope, const YAML::Node& map, const std::string& what,
                const std::vector<std::string>& known) {
  if (!map.IsMap()) fail(scope, map, what + " must be a mapping of keys to values");
  for (const auto& entry : map) {
    const std::string& key = entry.first.Scalar();
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    fail(scope, entry.first,
         what + " has an unknown key \"" + key + "\"" + text::nearest_match_hint(key, known));
  }
}

void check_list(const LaunchScope& scope, const YAML::Node& node, const std::string& what) {
  if (node && !node.IsNull() && !node.IsSequence()) fail(scope, node, what);
}

std::string substitute(const LaunchScope& scope, const YAML::Node& place, const std::string& text) {
  std::string result;
  std::size_t done = 0;
  for (auto begin = text.find("$("); begin != std::string::npos; begin = text.find("$(", done)) {
    const auto end = text.find(')', begin);
    if (end == std::string::npos)
      fail(scope, place, "\"" + text + "\" lacks a closing parenthesis");
    const std::string name = trimmed(std::string_view(text).substr(begin + 2, end - begin - 2));
    const auto value = scope.values.find(name);
    if (value == scope.values.end()) {
      std::vector<std::string> known;
      for (const auto& entry : scope.values) known.push_back(entry.first);
      fail(scope, place,
           "unknown argument $(" + name + ")" + text::nearest_match_hint(name, known));
    }
    if (scope.use) scope.use->use(name);
    result += text.substr(done, begin - done) + value->second;
    done = end + 1;
    if (result.size() > kLongestText) fail(scope, place, "arguments make a text beyond 64 KiB");
  }
  return result + text.substr(done);
}

std::string text_of(const LaunchScope& scope, const YAML::Node& node, const std::string& what) {
  if (!node || node.IsNull()) return "";
  if (!node.IsScalar()) fail(scope, node, what + " must be one value, not a list or mapping");
  return substitute(scope, node, node.Scalar());
}

std::string value_text_of(const LaunchScope& scope, const YAML::Node& node,
                          const std::string& what) {
  if (!node || !node.IsSequence()) return text_of(scope, node, what);
  std::vector<std::string> items;
  for (const YAML::Node& item : node) items.push_back(text_of(scope, item, "each of " + what));
  return graph::join_list(items);
}

bool bool_of(const LaunchScope& scope, const YAML::Node& node, const std::string& what) {
  const std::string text = text_of(scope, node, what);
  if (is_open(text)) return false;
  const auto truth = truth_of(text);
  if (!truth) fail(scope, node, what + " must be true or false, is \"" + text + "\"");
  return *truth;
}

double number_of(const LaunchScope& scope, const YAML::Node& node, const std::string& what,
                 double most, double otherwise) {
  const std::string text = text_of(scope, node, what);
  if (!node || is_open(text)) return otherwise;
  double number = -1;
  if (is_number<double>(text)) std::from_chars(text.data(), text.data() + text.size(), number);
  if (!(number >= 0 && number <= most)) {
    fail(scope, node, fmt::format("{} must be a number from 0 to {}, is \"{}\"", what, most, text));
  }
  return number;
}

std::vector<std::string> text_list_of(const LaunchScope& scope, const YAML::Node& node,
                                      const std::string& what) {
  std::vector<std::string> list;
  if (node && node.IsSequence()) {
    for (const YAML::Node& item : node) list.push_back(text_of(scope, item, "each of " + what));
    return list;
  }
  if (node && node.IsMap()) fail(scope, node, what + " must be a list");
  std::string text = text_of(scope, node, what);
  std::replace(text.begin(), text.end(), ',', ' ');
  std::istringstream words(text);
  for (std::string word; words >> word;) list.push_back(word);
  return list;
}

std::map<std::string, std::string> text_map_of(const LaunchScope& scope, const YAML::Node& node,
                                               const std::string& what, Values values,
                                               std::map<std::string, std::string>* places) {
  std::map<std::string, std::string> entries;
  if (node && !node.IsNull()) add_entries(scope, node, what, "", values, entries, places);
  return entries;
}

bool condition_of(const LaunchScope& scope, const YAML::Node& node) {
  if (!node) return true;
  if (!node.IsScalar())
    fail(scope, node, "if must be one value, e.g. $(viewer) or $(mode) == fast");
  const std::string& text = node.Scalar();
  // Split before substitution, so that an argument's value may hold "==".
  auto split = text.find("==");
  const bool unequal = split == std::string::npos;
  if (unequal) split = text.find("!=");
  if (split != std::string::npos) {
    const auto side = [&](std::string_view part) {
      return unquoted(trimmed(substitute(scope, node, std::string(part))));
    };
    const bool same = side(std::string_view(text).substr(0, split)) ==
                      side(std::string_view(text).substr(split + 2));
    return same != unequal;
  }
  const std::string value = trimmed(substitute(scope, node, text));
  if (is_open(value)) return false;
  const auto truth = truth_of(value);
  if (!truth) fail(scope, node, "if must be true, false, a == b or a != b; is \"" + value + "\"");
  return *truth;
}

void check_type(const LaunchScope& scope, const YAML::Node& place, const LaunchArgument& argument,
                const std::string& value) {
  if (is_open(value)) return;
  const auto expect = [&](bool right, const char* type) {
    if (!right) {
      fail(scope, place,
           "argument " + argument.name + " must be " + type + ", is \"" + value + "\"");
    }
  };
  if (argument.type == LaunchArgument::Type::kBool)
    expect(truth_of(value).has_value(), "true or false");
  if (argument.type == LaunchArgument::Type::kInteger)
    expect(is_number<long long>(value), "an integer");
  if (argument.type == LaunchArgument::Type::kNumber) expect(is_number<double>(value), "a number");
  if (argument.type == LaunchArgument::Type::kList) expect(is_list(value), "a list, as in [a, b]");
  const auto& choices = argument.choices;
  if (choices.empty() || std::find(choices.begin(), choices.end(), value) != choices.end()) return;
  fail(scope, place,
       fmt::format("argument {} must be one of {}, is \"{}\"{}", argument.name,
                   fmt::join(choices, ", "), value, text::nearest_match_hint(value, choices)));
}

}  // namespace prehend::launch
