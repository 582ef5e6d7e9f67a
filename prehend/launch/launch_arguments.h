#pragma once

#include "prehend/launch/launch_values.h"

// The `arguments:` of a launch file.
namespace prehend::launch {

/// What a file's `arguments:` declares; defaults have substitutions, of earlier ones too.
std::vector<LaunchArgument> arguments_of(const LaunchScope& scope, const YAML::Node& root);

/// Gives every declared argument its value in `scope`; `given_at` is where given values come from.
/// Adds those that stay open to `open`.
void take_arguments(LaunchScope& scope, const YAML::Node& root,
                    const std::map<std::string, std::string>& given, const std::string& given_at,
                    Missing missing, std::vector<std::string>& open);

/// Adds what a file's `values:` declares to `scope`: names for what arguments amount to, NAME:
/// {then: TEXT, if: CONDITION, otherwise: TEXT}. Later ones may use earlier ones.
void take_values(LaunchScope& scope, const YAML::Node& list);
/// The names of those.
std::vector<std::string> value_names(const YAML::Node& list);

}  // namespace prehend::launch
