#include "prehend/launch/launch_arguments.h"

#include <algorithm>

#include "prehend/launch/launch_file.h"
#include "prehend/text/named_file.h"
#include "prehend/text/nearest_match.h"

namespace prehend::launch {
namespace {

LaunchArgument::Type type_named(const LaunchScope& scope, const YAML::Node& node) {
  const std::string name = text_of(scope, node, "type");
  if (name == "string") return LaunchArgument::Type::kString;
  if (name == "int") return LaunchArgument::Type::kInteger;
  if (name == "double") return LaunchArgument::Type::kNumber;
  if (name == "bool") return LaunchArgument::Type::kBool;
  if (name == "list") return LaunchArgument::Type::kList;
  fail(scope, node,
       "unknown argument type \"" + name + "\"" +
           text::nearest_match_hint(name, {"string", "int", "double", "bool", "list"}));
}

LaunchArgument argument_of(const LaunchScope& scope, const YAML::Node& key,
                           const YAML::Node& value) {
  LaunchArgument argument;
  argument.name = key.Scalar();
  if (scope.values.count(argument.name) > 0) {
    fail(scope, key, "argument " + argument.name + " has a name that is already taken");
  }
  if (value.IsNull()) return argument;
  check_keys(scope, value, "argument " + argument.name,
             {"default", "type", "description", "choices"});
  if (value["type"]) argument.type = type_named(scope, value["type"]);
  if (value["description"]) {
    argument.description = text_of(scope, value["description"], "description");
  }
  argument.choices = text_list_of(scope, value["choices"], "choices of " + argument.name);
  if (value["default"]) {
    argument.default_value =
        argument.type == LaunchArgument::Type::kList
            ? value_text_of(scope, value["default"], "default of " + argument.name)
            : text_of(scope, value["default"], "default of " + argument.name);
    check_type(scope, value["default"], argument, *argument.default_value);
  }
  return argument;
}

void check_mapping(const LaunchScope& scope, const YAML::Node& list) {
  if (!list || list.IsNull() || list.IsMap()) return;
  fail(scope, list,
       "arguments must be a mapping of names to {default, type, description, choices}");
}

}  // namespace

std::vector<LaunchArgument> arguments_of(const LaunchScope& scope, const YAML::Node& root) {
  std::vector<LaunchArgument> arguments;
  LaunchScope known = scope;
  check_mapping(scope, root["arguments"]);
  for (const auto& entry : root["arguments"]) {
    arguments.push_back(argument_of(known, entry.first, entry.second));
    const LaunchArgument& argument = arguments.back();
    known.values[argument.name] = argument.default_value.value_or("$(" + argument.name + ")");
  }
  return arguments;
}

void take_arguments(LaunchScope& scope, const YAML::Node& root,
                    const std::map<std::string, std::string>& given, const std::string& given_at,
                    Missing missing, std::vector<std::string>& open) {
  std::vector<std::string> declared;
  check_mapping(scope, root["arguments"]);
  for (const auto& entry : root["arguments"]) {
    const LaunchArgument argument = argument_of(scope, entry.first, entry.second);
    declared.push_back(argument.name);
    const auto value = given.find(argument.name);
    if (value != given.end()) {
      if (missing == Missing::kRefuse && is_open(value->second)) {
        throw LaunchError(given_at + ": argument " + argument.name + " holds \"$(\", is \"" +
                          value->second + "\"; write the value itself");
      }
      check_type(scope, entry.first, argument, value->second);
      scope.values[argument.name] = value->second;
    } else if (argument.default_value) {
      scope.values[argument.name] = *argument.default_value;
    } else if (missing == Missing::kLeaveOpen) {
      scope.values[argument.name] = "$(" + argument.name + ")";
      open.push_back(argument.name);
    } else {
      const std::string why = argument.description.empty() ? "" : " (" + argument.description + ")";
      fail(scope, entry.first,
           "argument " + argument.name + why + " needs a value: " + argument.name + ":=...");
    }
  }
  for (const auto& [name, value] : given) {
    if (std::find(declared.begin(), declared.end(), name) != declared.end()) continue;
    throw LaunchError(given_at + ": " + scope.file + " has no argument \"" + name + "\"" +
                      text::nearest_match_hint(name, declared));
  }
}

void take_values(LaunchScope& scope, const YAML::Node& list) {
  if (!list || list.IsNull()) return;
  if (!list.IsMap()) {
    fail(scope, list, "values must be a mapping of names to {then, if, otherwise} or {file, of}");
  }
  for (const auto& entry : list) {
    const std::string& name = entry.first.Scalar();
    const std::string what = "value " + name;
    if (scope.values.count(name) > 0) {
      fail(scope, entry.first, what + " has a name that is already taken");
    }
    const bool is_file = entry.second.IsMap() && entry.second["file"];
    const std::vector<std::string> keys = is_file
                                              ? std::vector<std::string>{"file", "of"}
                                              : std::vector<std::string>{"then", "if", "otherwise"};
    check_keys(scope, entry.second, what, keys);
    for (const std::string& key : keys) {
      if (!entry.second[key]) fail(scope, entry.second, what + " needs the key \"" + key + "\"");
    }
    if (is_file) {
      const std::string file = text_of(scope, entry.second["file"], what);
      const std::string folder = text_of(scope, entry.second["of"], what);
      // Whether there is such a file is known when the argument is.
      scope.values[name] = is_open(file) ? file : text::file_meant(folder, file).string();
      continue;
    }
    const bool holds = condition_of(scope, entry.second["if"]);
    scope.values[name] = text_of(scope, entry.second[holds ? "then" : "otherwise"], what);
  }
}

std::vector<std::string> value_names(const YAML::Node& list) {
  std::vector<std::string> names;
  if (!list || !list.IsMap()) return names;
  for (const auto& entry : list) names.push_back(entry.first.Scalar());
  return names;
}

}  // namespace prehend::launch
