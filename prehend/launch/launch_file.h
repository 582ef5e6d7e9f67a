#pragma once

#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace prehend::launch {

/// Something is wrong in a launch file or with its arguments. what() is
/// "FILE:LINE: what is wrong, and the nearest match where a name was misspelt".
class LaunchError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An argument a launch file declares. Its value on the command line: `name:=value`.
struct LaunchArgument {
  enum class Type { kString, kInteger, kNumber, kBool, kList };
  std::string name;
  Type type = Type::kString;
  std::optional<std::string> default_value;  ///< none: a value must be given
  std::string description;
  std::vector<std::string> choices;  ///< empty: any value of its type
};

/// Whether a process is started again when it dies, and when.
struct Respawn {
  bool wanted = false;
  double first_delay = 0.5;   ///< s, doubles each time
  double longest_delay = 10;  ///< s
  bool operator==(const Respawn&) const = default;
};

/// One node to start, everything resolved.
struct LaunchNode {
  std::string name;        ///< unique in the graph, with its namespace before it: left_camera
  std::string program;     ///< name of the executable
  std::string executable;  ///< its path
  bool by_path = false;    ///< the launch file names it by its path
  std::string clock;       ///< "wall", "simulated", or "" for the program's default
  std::string name_space;  ///< e.g. "/left"; "" for none
  std::map<std::string, std::string> parameters;        ///< nested keys joined with '.'
  std::map<std::string, std::string> parameter_places;  ///< the same keys -> "FILE:LINE"
  std::string parameter_file;                           ///< path, or ""
  std::map<std::string, std::string> remaps;            ///< from -> name in the graph
  std::map<std::string, std::string> environment;
  std::vector<int> cpu_affinity;   ///< CPUs it may run on; empty: all
  int nice = 0;                    ///< by which it yields to others more than the launch, 0 to 19
  std::string host;                ///< name in LaunchGraph::hosts; "" when there are none
  std::string process;             ///< `compose:` nodes of one name share a process; "": its own
  std::vector<std::string> after;  ///< names of nodes that have to be ready before
  bool required = false;           ///< its end is the end of the launch
  Respawn respawn;
  std::optional<double> stop_time;  ///< [s] to end in, once asked to; none: what its program says
  std::string place;                ///< "FILE:LINE" it comes from
};

/// A machine that runs a part of the graph.
struct LaunchHost {
  std::string name;
  std::string address;  ///< what its nodes bind to and others connect to
};

/// What a launch file and its arguments resolve to.
struct LaunchGraph {
  std::string file;                              ///< absolute path
  std::map<std::string, std::string> arguments;  ///< of the top file, with their final values
  std::vector<std::string> missing_arguments;    ///< see Missing::kLeaveOpen
  std::vector<LaunchHost> hosts;                 ///< empty: all on this machine, on loopback
  std::string registry_host;                     ///< where the registry runs; "" without hosts
  std::string log_directory;                     ///< or ""
  std::vector<std::string> warnings;             ///< to be said at the start
  std::vector<LaunchNode> nodes;  ///< in the order of the file, includes where they stand
};

/// What becomes of arguments that have no default and get no value.
enum class Missing {
  kRefuse,
  kLeaveOpen,  ///< stays as "$(name)", and what depends on it is not checked
};

/// True when the text depends on an argument that has no value.
bool is_open(const std::string& text);

/// Splits command line words "name:=value"; throws LaunchError for any other word.
std::map<std::string, std::string> parse_arguments(const std::vector<std::string>& words);

/// The arguments the launch file itself declares. Throws LaunchError.
std::vector<LaunchArgument> declared_arguments(const std::string& path);

/// Reads a launch file and everything it includes, and resolves it. All keys: launch/README.md.
/// `node_path`: folders in which programs are looked for, separated by ':', the first one first; a
/// program may be named by its path instead, seen from the launch file. Unknown keys, programs and
/// arguments, duplicate names and keys, values of a wrong type, missing files, cyclic includes and
/// start orders, nodes of one process that contradict each other, and files beyond all measure
/// throw LaunchError.
LaunchGraph load_launch_file(const std::string& path,
                             const std::map<std::string, std::string>& arguments,
                             const std::string& node_path, Missing missing = Missing::kRefuse);

/// The resolved graph as YAML that load_launch_file would accept, groups and includes resolved.
std::string describe(const LaunchGraph& graph);

/// The options a node is started with, without its program. `address`: to bind to, or "".
std::vector<std::string> node_options(const LaunchNode& node, const std::string& address);

}  // namespace prehend::launch
