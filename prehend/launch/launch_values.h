#pragma once

#include <yaml-cpp/yaml.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "prehend/launch/argument_use.h"
#include "prehend/launch/launch_file.h"

// Reading single values of launch files.
namespace prehend::launch {

/// One launch file while it is read: its place for messages, and what `$(...)` stands for.
struct LaunchScope {
  std::string file;                           ///< absolute path
  std::map<std::string, std::string> values;  ///< arguments, launch_dir, root
  ArgumentUse* use = nullptr;                 ///< told of every substitution; may be null
};

/// The shorter of the path itself and the path from the working directory.
std::string short_path(const std::string& path);

/// "FILE:LINE" of a YAML node, FILE as a short path.
std::string place_of(const LaunchScope& scope, const YAML::Node& node);

/// Throws LaunchError "FILE:LINE: text".
[[noreturn]] void fail(const LaunchScope& scope, const YAML::Node& node, const std::string& text);

/// Throws unless `map` is a mapping whose keys are all in `known`; `what` names it in the message.
void check_keys(const LaunchScope& scope, const YAML::Node& map, const std::string& what,
                const std::vector<std::string>& known);

/// Throws unless `node` is a list, nothing, or null; `what` says what it should be a list of.
void check_list(const LaunchScope& scope, const YAML::Node& node, const std::string& what);

/// Replaces every `$(name)`; throws for unknown names, unclosed parentheses and results beyond
/// 64 KiB.
std::string substitute(const LaunchScope& scope, const YAML::Node& place, const std::string& text);

/// The text of a scalar, with substitution; "" for null and nothing.
std::string text_of(const LaunchScope& scope, const YAML::Node& node, const std::string& what);
/// The same; a list of scalars becomes the text form of a list (graph/parameter_list.h).
std::string value_text_of(const LaunchScope& scope, const YAML::Node& node,
                          const std::string& what);
bool bool_of(const LaunchScope& scope, const YAML::Node& node, const std::string& what);
/// A number from 0 to `most`; `otherwise` when the key is not there.
double number_of(const LaunchScope& scope, const YAML::Node& node, const std::string& what,
                 double most, double otherwise);

/// A list of texts; also one text whose parts are separated by commas or spaces. May be empty.
std::vector<std::string> text_list_of(const LaunchScope& scope, const YAML::Node& node,
                                      const std::string& what);

/// What may stand in a mapping: parameters and arguments may be lists, a remap or variable not.
enum class Values { kSingle, kSingleOrLists };

/// A mapping of names to texts as text_of or value_text_of gives them, nested mappings joined with
/// '.'. `places`, when given, takes "FILE:LINE" of each.
std::map<std::string, std::string> text_map_of(
    const LaunchScope& scope, const YAML::Node& node, const std::string& what, Values values,
    std::map<std::string, std::string>* places = nullptr);

/// The value of an `if:` key: true | false | a == b | a != b. True when the key is not there.
bool condition_of(const LaunchScope& scope, const YAML::Node& node);

/// Reads `value` as the argument's type; throws unless it is one, and one of its choices.
void check_type(const LaunchScope& scope, const YAML::Node& place, const LaunchArgument& argument,
                const std::string& value);

}  // namespace prehend::launch
