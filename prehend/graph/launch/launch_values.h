#pragma once

#include <yaml-cpp/yaml.h>

#include <map>
#include <string>
#include <vector>

#include "prehend/graph/launch/launch_file.h"

// Reading single values of launch files.
namespace prehend::graph::launch {

/// One launch file while it is read: its place for messages, and what `$(...)` stands for.
struct LaunchScope {
  std::string file;                           ///< absolute path
  std::map<std::string, std::string> values;  ///< arguments, launch_dir, root
};

/// "FILE:LINE" of a YAML node, FILE as a short path.
std::string place_of(const LaunchScope& scope, const YAML::Node& node);

/// Throws LaunchError "FILE:LINE: text".
[[noreturn]] void fail(const LaunchScope& scope, const YAML::Node& node, const std::string& text);

/// Throws unless `map` is a mapping whose keys are all in `known`; `what` names it in the message.
void check_keys(const LaunchScope& scope, const YAML::Node& map, const std::string& what,
                const std::vector<std::string>& known);

/// Replaces every `$(name)`; throws for unknown names and unclosed parentheses.
std::string substitute(const LaunchScope& scope, const YAML::Node& place, const std::string& text);

/// The text of a scalar, with substitution.
std::string text_of(const LaunchScope& scope, const YAML::Node& node, const std::string& what);
bool bool_of(const LaunchScope& scope, const YAML::Node& node, const std::string& what);

/// A mapping of names to scalars, nested mappings joined with '.', with substitution.
std::map<std::string, std::string> text_map_of(const LaunchScope& scope, const YAML::Node& node,
                                               const std::string& what);

/// The value of an `if:` key: true | false | a == b | a != b.
bool condition_of(const LaunchScope& scope, const YAML::Node& node);

/// Throws unless `value` is one of the argument's type.
void check_type(const LaunchScope& scope, const YAML::Node& place, const LaunchArgument& argument,
                const std::string& value);

}  // namespace prehend::graph::launch
