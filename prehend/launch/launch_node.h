#pragma once

#include "prehend/launch/launch_values.h"

// The nodes of a launch file, and the settings they inherit.
namespace prehend::launch {

/// What a launch file, a group, an include or a node says for everything inside it.
struct LaunchSettings {
  std::string clock, name_space, host, process;
  std::map<std::string, std::string> environment;
  std::vector<int> cpu_affinity;
  int nice = 0;
};

/// The keys that settings_of reads.
std::vector<std::string> setting_keys();

/// `inherited`, changed by what `entry` says. `hosts`: those of the launch.
LaunchSettings settings_of(const LaunchScope& scope, const YAML::Node& entry,
                           const LaunchSettings& inherited, const std::vector<LaunchHost>& hosts);

/// "camera" in the namespace "/left" is left_camera.
std::string name_in(const std::string& name_space, const std::string& name);

/// The name that a node has or would have.
std::string node_name_of(const LaunchScope& scope, const YAML::Node& entry,
                         const LaunchSettings& settings);

/// One entry of `nodes:`; `settings` are its own, `node_path` as of load_launch_file. Throws
/// LaunchError.
LaunchNode node_of(const LaunchScope& scope, const YAML::Node& entry,
                   const LaunchSettings& settings, const std::string& node_path);

/// A file named relative to the launch file; throws when it does not exist.
std::string file_beside(const LaunchScope& scope, const YAML::Node& node, const std::string& what);

/// Throws unless `name` can name a node, process or host.
void check_name(const LaunchScope& scope, const YAML::Node& place, const std::string& name,
                const std::string& what);

}  // namespace prehend::launch
