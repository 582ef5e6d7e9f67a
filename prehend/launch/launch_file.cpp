#include "prehend/launch/launch_file.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "prehend/launch/launch_arguments.h"
#include "prehend/launch/launch_node.h"
#include "prehend/launch/process_plan.h"
#include "prehend/text/nearest_match.h"
#include "prehend/text/strict_yaml.h"

namespace prehend::launch {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostFiles = 1000;  // read, each as often as it is included
constexpr std::size_t kMostNodes = 1000;

YAML::Node parse_file(const LaunchScope& scope) {
  if (!fs::is_regular_file(scope.file)) {
    throw LaunchError(scope.file + ": there is no such launch file");
  }
  try {
    return text::load_strict_yaml(short_path(scope.file));
  } catch (const text::YamlError& error) {
    throw LaunchError(error.what());
  }
}

LaunchScope scope_of(const std::string& path) {
  LaunchScope scope;
  scope.file = fs::absolute(path).lexically_normal().string();
  const fs::path folder = fs::path(scope.file).parent_path();
  scope.values["launch_dir"] = folder.string();
  scope.values["root"] = folder.parent_path().string();
  return scope;
}

std::vector<std::string> with_settings(std::vector<std::string> keys) {
  const std::vector<std::string> more = setting_keys();
  keys.insert(keys.end(), more.begin(), more.end());
  return keys;
}

void check_top_level(const LaunchScope& scope, const YAML::Node& root) {
  if (root.IsNull()) throw LaunchError(scope.file + ": the launch file is empty");
  check_keys(scope, root, "the launch file",
             with_settings({"nodes", "include", "groups", "arguments", "hosts", "registry_host",
                            "log_directory", "warnings", "values", "refusals"}));
}

class Loader {
 public:
  Loader(std::string node_path, Missing missing, LaunchGraph& graph)
      : node_path_(std::move(node_path)), missing_(missing), graph_(graph) {}

  void load_top(const std::string& path, const std::map<std::string, std::string>& given) {
    const ArgumentUse use = load(path, given, "command line", {});
    check_use(given, use);
    resolve_hosts();
    resolve_start_order();
  }

 private:
  // Adds what the file asks for to the graph. Returns which of its arguments had an effect.
  ArgumentUse load(const std::string& path, const std::map<std::string, std::string>& given,
                   const std::string& given_at, const LaunchSettings& inherited) {
    LaunchScope scope = scope_of(path);
    check_cycle(scope.file, given_at);
    if (++files_read_ > kMostFiles) {
      throw LaunchError(given_at + ": more than " + std::to_string(kMostFiles) + " includes");
    }
    const bool is_top = chain_.empty();
    chain_.push_back(scope.file);
    const YAML::Node root = parse_file(scope);
    check_top_level(scope, root);
    take_arguments(scope, root, given, given_at, missing_, graph_.missing_arguments);
    ArgumentUse use;
    scope.use = &use;
    take_values(scope, root["values"]);
    refuse(scope, root["refusals"]);
    take_launch_keys(scope, root, is_top);
    add_warnings(scope, root["warnings"]);
    add_content(scope, root, settings_of(scope, root, inherited, graph_.hosts));
    use.use_defaults(root["arguments"], given);
    chain_.pop_back();
    if (is_top) {
      graph_.arguments = scope.values;
      graph_.arguments.erase("launch_dir");
      graph_.arguments.erase("root");
      for (const std::string& name : value_names(root["values"])) graph_.arguments.erase(name);
    }
    return use;
  }

  // An argument that was given and has no effect is a mistake, of this argument or of another.
  void check_use(const std::map<std::string, std::string>& given, const ArgumentUse& use) const {
    if (!graph_.missing_arguments.empty()) return;  // what depends on those was not looked at
    for (const auto& [name, value] : given) {
      if (use.is_used(name)) continue;
      const std::string condition = use.left_out_by(name);
      throw LaunchError("command line: " + name + ":=" + value + " has no effect: " +
                        (condition.empty() ? "nothing in the launch file uses it; leave it away"
                                           : "what it is for is left out at " + condition +
                                                 "; change that, or leave it away"));
    }
  }

  // Whether a part of the file is wanted; notes what it would have used when not.
  static bool is_wanted(const LaunchScope& scope, const YAML::Node& part) {
    if (condition_of(scope, part["if"])) return true;
    scope.use->leave_out(part, place_of(scope, part["if"]) + " (if: " + part["if"].Scalar() + ")");
    return false;
  }

  void check_cycle(const std::string& file, const std::string& given_at) const {
    if (std::find(chain_.begin(), chain_.end(), file) == chain_.end()) return;
    std::string text = given_at + ": launch files include each other in a circle: ";
    for (const std::string& link : chain_) text += link + " -> ";
    throw LaunchError(text + file);
  }

  // Keys that only the launched file itself may have, as they are of the launch as a whole.
  void take_launch_keys(const LaunchScope& scope, const YAML::Node& root, bool is_top) {
    for (const char* key : {"hosts", "registry_host", "log_directory"}) {
      if (root[key] && !is_top) {
        fail(
            scope, root[key],
            std::string(key) + " is for the launched file, not for an included one; move it there");
      }
    }
    take_hosts(scope, root["hosts"]);
    graph_.log_directory = text_of(scope, root["log_directory"], "log_directory");
    if (!graph_.hosts.empty()) graph_.registry_host = graph_.hosts[0].name;
    if (!root["registry_host"]) return;
    const std::string host = text_of(scope, root["registry_host"], "registry_host");
    std::vector<std::string> known;
    for (const LaunchHost& other : graph_.hosts) known.push_back(other.name);
    if (std::find(known.begin(), known.end(), host) == known.end()) {
      fail(scope, root["registry_host"],
           "registry_host " + host + " is not among the hosts" +
               text::nearest_match_hint(host, known));
    }
    graph_.registry_host = host;
  }

  void take_hosts(const LaunchScope& scope, const YAML::Node& hosts) {
    if (!hosts || hosts.IsNull()) return;
    if (!hosts.IsMap()) fail(scope, hosts, "hosts must be a mapping of names to {address: ...}");
    for (const auto& entry : hosts) {
      LaunchHost host;
      host.name = entry.first.Scalar();
      check_name(scope, entry.first, host.name, "host");
      check_keys(scope, entry.second, "host " + host.name, {"address"});
      host.address = text_of(scope, entry.second["address"], "address");
      const bool plain =
          !host.address.empty() && host.address.find_first_of("/* \t") == std::string::npos;
      if (!plain && !is_open(host.address)) {
        fail(scope, entry.second,
             "host " + host.name + " needs an address like 10.0.0.1, without tcp://");
      }
      graph_.hosts.push_back(host);
    }
  }

  // What the file does not offer, said before anything of it is looked at.
  void refuse(const LaunchScope& scope, const YAML::Node& list) {
    check_list(scope, list, "refusals must be a list of {text: ..., if: ...}");
    for (const YAML::Node& entry : list) {
      check_keys(scope, entry, "a refusal", {"text", "if"});
      if (!entry["text"] || !entry["if"]) {
        fail(scope, entry, "a refusal needs the keys \"text\" and \"if\"");
      }
      if (condition_of(scope, entry["if"]))
        fail(scope, entry, text_of(scope, entry["text"], "text"));
    }
  }

  void add_warnings(const LaunchScope& scope, const YAML::Node& list) {
    check_list(scope, list, "warnings must be a list of {text: ..., if: ...}");
    for (const YAML::Node& entry : list) {
      check_keys(scope, entry, "a warning", {"text", "if"});
      if (!entry["text"]) fail(scope, entry, "a warning needs the key \"text\"");
      if (is_wanted(scope, entry)) {
        graph_.warnings.push_back(text_of(scope, entry["text"], "text"));
      }
    }
  }

  // The includes, groups and nodes of a file or group.
  void add_content(const LaunchScope& scope, const YAML::Node& part,
                   const LaunchSettings& settings) {
    add_includes(scope, part["include"], settings);
    add_groups(scope, part["groups"], settings);
    add_nodes(scope, part["nodes"], settings);
  }

  void add_includes(const LaunchScope& scope, const YAML::Node& list,
                    const LaunchSettings& inherited) {
    check_list(scope, list, "include must be a list of {file: ..., arguments: ...}");
    for (const YAML::Node& entry : list) {
      check_keys(scope, entry, "an include", with_settings({"file", "arguments", "if"}));
      if (!entry["file"]) fail(scope, entry, "an include needs the key \"file\"");
      if (!is_wanted(scope, entry)) continue;
      LaunchScope handing = scope;
      handing.use = nullptr;  // used when the included file does
      const auto arguments =
          text_map_of(handing, entry["arguments"], "arguments", Values::kSingleOrLists);
      const std::string file = file_beside(scope, entry["file"], "included file");
      if (file.empty()) continue;  // depends on an argument without a value
      const ArgumentUse inner = load(file, arguments, place_of(scope, entry),
                                     settings_of(scope, entry, inherited, graph_.hosts));
      scope.use->hand_on(entry["arguments"], inner);
    }
  }

  void add_groups(const LaunchScope& scope, const YAML::Node& list,
                  const LaunchSettings& inherited) {
    check_list(scope, list, "groups must be a list of {namespace: ..., nodes: ..., ...}");
    for (const YAML::Node& entry : list) {
      check_keys(scope, entry, "a group", with_settings({"if", "nodes", "include", "groups"}));
      if (!is_wanted(scope, entry)) continue;
      add_content(scope, entry, settings_of(scope, entry, inherited, graph_.hosts));
    }
  }

  void add_nodes(const LaunchScope& scope, const YAML::Node& list,
                 const LaunchSettings& inherited) {
    check_list(scope, list, "nodes must be a list of {node: ..., ...}");
    for (const YAML::Node& entry : list) {
      check_keys(scope, entry, "a node",
                 with_settings({"node", "name", "parameters", "parameter_file", "remap", "required",
                                "respawn", "after", "stop_time", "if"}));
      if (!entry["node"]) fail(scope, entry, "a node needs the key \"node\", its program");
      const LaunchSettings settings = settings_of(scope, entry, inherited, graph_.hosts);
      if (!is_wanted(scope, entry)) {
        switched_off_.insert(node_name_of(scope, entry, settings));
        continue;
      }
      LaunchNode node = node_of(scope, entry, settings, node_path_);
      for (const LaunchNode& other : graph_.nodes) {
        if (other.name != node.name) continue;
        fail(scope, entry,
             "a node named \"" + node.name + "\" is already at " + other.place +
                 "; give one of them another name");
      }
      graph_.nodes.push_back(std::move(node));
      if (graph_.nodes.size() > kMostNodes) {
        fail(scope, entry, "more than " + std::to_string(kMostNodes) + " nodes");
      }
    }
  }

  void resolve_hosts() {
    for (LaunchNode& node : graph_.nodes) {
      if (node.host.empty()) node.host = graph_.registry_host;
    }
  }

  // `after:` names a node as it is called inside its own file, or inside the ones around it.
  void resolve_start_order() {
    std::vector<std::string> names;
    for (const LaunchNode& node : graph_.nodes) names.push_back(node.name);
    const std::set<std::string> known(names.begin(), names.end());
    for (LaunchNode& node : graph_.nodes) {
      std::vector<std::string> resolved;
      for (const std::string& name : node.after) {
        std::string name_space = node.name_space;
        std::string full = name_in(name_space, name);
        while (known.count(full) + switched_off_.count(full) == 0 && !name_space.empty()) {
          name_space.resize(name_space.rfind('/'));
          full = name_in(name_space, name);
        }
        if (known.count(full) > 0) {
          resolved.push_back(full);
        } else if (switched_off_.count(full) == 0 && !is_open(name)) {
          throw LaunchError(node.place + ": after: there is no node \"" + name + "\"" +
                            text::nearest_match_hint(name, names));
        }
      }
      node.after = resolved;
    }
  }

  const std::string node_path_;
  const Missing missing_;
  LaunchGraph& graph_;
  std::vector<std::string> chain_;  // of files being read, the top one first
  std::size_t files_read_ = 0;
  std::set<std::string> switched_off_;  // nodes by their `if:`
};

}  // namespace

std::map<std::string, std::string> parse_arguments(const std::vector<std::string>& words) {
  std::map<std::string, std::string> arguments;
  for (const std::string& word : words) {
    const auto split = word.find(":=");
    if (split == std::string::npos || split == 0) {
      throw LaunchError("command line: \"" + word + "\" is no argument; write name:=value");
    }
    if (!arguments.emplace(word.substr(0, split), word.substr(split + 2)).second) {
      throw LaunchError("command line: argument " + word.substr(0, split) + " is given twice");
    }
  }
  return arguments;
}

std::vector<LaunchArgument> declared_arguments(const std::string& path) {
  const LaunchScope scope = scope_of(path);
  const YAML::Node root = parse_file(scope);
  check_top_level(scope, root);
  return arguments_of(scope, root);
}

LaunchGraph load_launch_file(const std::string& path,
                             const std::map<std::string, std::string>& arguments,
                             const std::string& node_path, Missing missing) {
  LaunchGraph graph;
  graph.file = scope_of(path).file;
  Loader loader(node_path, missing, graph);
  try {
    loader.load_top(path, arguments);
  } catch (const YAML::Exception& error) {
    throw LaunchError(graph.file + ": " + error.what());
  }
  if (graph.nodes.empty()) throw LaunchError(graph.file + ": there are no nodes to start");
  check_processes(graph);
  return graph;
}

}  // namespace prehend::launch
