#include "prehend/graph/launch/launch_values.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>

#include "prehend/graph/nearest_match.h"

namespace prehend::graph::launch {
namespace {

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

template <class Number>
bool is_number(const std::string& text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

void add_entries(const LaunchScope& scope, const YAML::Node& node, const std::string& what,
                 const std::string& prefix, std::map<std::string, std::string>& entries) {
  if (!node.IsMap()) fail(scope, node, what + " must be a mapping of names to values");
  for (const auto& entry : node) {
    const std::string key = prefix + entry.first.as<std::string>();
    if (entry.second.IsMap()) {
      add_entries(scope, entry.second, what, key + ".", entries);
    } else {
      const std::string value = text_of(scope, entry.second, what + " " + key);
      if (!entries.emplace(key, value).second) {
        fail(scope, entry.first, what + " gives " + key + " twice");
      }
    }
  }
}

}  // namespace

std::string place_of(const LaunchScope& scope, const YAML::Node& node) {
  std::error_code error;
  std::string path = std::filesystem::proximate(scope.file, error).string();
  if (error || path.size() > scope.file.size()) path = scope.file;
  return path + ":" + std::to_string(node.Mark().line + 1);
}

void fail(const LaunchScope& scope, const YAML::Node& node, const std::string& text) {
  throw LaunchError(place_of(scope, node) + ": " + text);
}

void check_keys(const LaunchScope& scope, const YAML::Node& map, const std::string& what,
                const std::vector<std::string>& known) {
  if (!map.IsMap()) fail(scope, map, what + " must be a mapping of keys to values");
  std::vector<std::string> seen;
  for (const auto& entry : map) {
    const std::string key = entry.first.as<std::string>();
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      fail(scope, entry.first,
           what + " has an unknown key \"" + key + "\"" + nearest_match_hint(key, known));
    }
    if (std::find(seen.begin(), seen.end(), key) != seen.end()) {
      fail(scope, entry.first, what + " has the key \"" + key + "\" twice");
    }
    seen.push_back(key);
  }
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
      fail(scope, place, "unknown argument $(" + name + ")" + nearest_match_hint(name, known));
    }
    result += text.substr(done, begin - done) + value->second;
    done = end + 1;
  }
  return result + text.substr(done);
}

std::string text_of(const LaunchScope& scope, const YAML::Node& node, const std::string& what) {
  if (node.IsNull()) return "";
  if (!node.IsScalar()) fail(scope, node, what + " must be one value, not a list or mapping");
  return substitute(scope, node, node.Scalar());
}

bool bool_of(const LaunchScope& scope, const YAML::Node& node, const std::string& what) {
  const std::string text = text_of(scope, node, what);
  const auto truth = truth_of(text);
  if (!truth) fail(scope, node, what + " must be true or false, is \"" + text + "\"");
  return *truth;
}

std::map<std::string, std::string> text_map_of(const LaunchScope& scope, const YAML::Node& node,
                                               const std::string& what) {
  std::map<std::string, std::string> entries;
  if (!node.IsNull()) add_entries(scope, node, what, "", entries);
  return entries;
}

bool condition_of(const LaunchScope& scope, const YAML::Node& node) {
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
  const auto truth = truth_of(value);
  if (!truth) fail(scope, node, "if must be true, false, a == b or a != b; is \"" + value + "\"");
  return *truth;
}

void check_type(const LaunchScope& scope, const YAML::Node& place, const LaunchArgument& argument,
                const std::string& value) {
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
}

}  // namespace prehend::graph::launch
