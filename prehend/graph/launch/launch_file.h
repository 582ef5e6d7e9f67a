#pragma once

#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace prehend::graph::launch {

/// Something is wrong in a launch file or with its arguments. what() is
/// "FILE:LINE: what is wrong, and the nearest match where a name was misspelt".
class LaunchError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An argument a launch file declares. Its value on the command line: `name:=value`.
struct LaunchArgument {
  enum class Type { kString, kInteger, kNumber, kBool };
  std::string name;
  Type type = Type::kString;
  std::optional<std::string> default_value;  ///< none: a value must be given
  std::string description;
};

/// One process to start, everything resolved.
struct LaunchNode {
  std::string name;        ///< unique in the graph
  std::string program;     ///< name of the executable
  std::string executable;  ///< its path
  std::string clock;       ///< "wall", "simulated", or "" for the program's default
  std::map<std::string, std::string> parameters;  ///< nested keys joined with '.'
  std::string parameter_file;                     ///< path, or ""
  std::map<std::string, std::string> remaps;      ///< from -> to
  std::map<std::string, std::string> environment;
  bool required = false;  ///< its end is the end of the launch
  bool respawn = false;   ///< start it again when it dies
  std::string place;      ///< "FILE:LINE" it comes from
};

/// What a launch file and its arguments resolve to.
struct LaunchGraph {
  std::string file;                              ///< absolute path
  std::map<std::string, std::string> arguments;  ///< of the top file, with their final values
  std::vector<LaunchNode> nodes;  ///< in the order of the file, includes where they stand
};

/// Splits command line words "name:=value"; throws LaunchError for any other word.
std::map<std::string, std::string> parse_arguments(const std::vector<std::string>& words);

/// The arguments the launch file itself declares. Throws LaunchError.
std::vector<LaunchArgument> declared_arguments(const std::string& path);

/// Reads a launch file and everything it includes, and resolves it:
///
///     arguments:            # all optional; without a default the argument must be given
///       scene: {default: demo, type: string, description: what stands on the table}
///     clock: simulated      # of every node that says nothing else: wall | simulated
///     include:
///       - {file: sensors.yaml, arguments: {rate: 5}, if: $(sensors)}
///     nodes:
///       - node: simulation                # name of a program beside `prehend`
///         name: world                     # default: the program's name
///         parameters: {scene: $(root)/config/scenes/$(scene).yaml, seed: 7}
///         parameter_file: simulation.yaml # relative to the launch file
///         remap: {/camera: /left/camera}
///         required: true
///         respawn: false
///         clock: wall
///         environment: {OMP_NUM_THREADS: "1"}
///         if: $(scene) == demo            # true | false | a == b | a != b
///
/// `$(name)` stands for an argument, `$(launch_dir)` for the file's folder and `$(root)` for the
/// folder above it. `node_folder` is where programs are looked for. Unknown keys, programs and
/// arguments, duplicate node names, values of a wrong type, missing files and cyclic includes throw
/// LaunchError.
LaunchGraph load_launch_file(const std::string& path,
                             const std::map<std::string, std::string>& arguments,
                             const std::string& node_folder);

/// The resolved graph as YAML that load_launch_file would accept.
std::string describe(const LaunchGraph& graph);

/// The command line a node is started with, the executable first.
std::vector<std::string> command_line(const LaunchNode& node);

}  // namespace prehend::graph::launch
