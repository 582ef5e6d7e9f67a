#include "prehend/graph/launch/launch_file.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "prehend/graph/launch/launch_values.h"
#include "prehend/graph/nearest_match.h"

namespace prehend::graph::launch {
namespace {

namespace fs = std::filesystem;

YAML::Node parse_file(const LaunchScope& scope) {
  if (!fs::is_regular_file(scope.file)) {
    throw LaunchError(scope.file + ": there is no such launch file");
  }
  try {
    return YAML::LoadFile(scope.file);
  } catch (const YAML::ParserException& error) {
    throw LaunchError(scope.file + ":" + std::to_string(error.mark.line + 1) + ": " + error.msg);
  } catch (const YAML::BadFile&) {
    throw LaunchError(scope.file + ": cannot be read");
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

void check_top_level(const LaunchScope& scope, const YAML::Node& root) {
  if (root.IsNull()) throw LaunchError(scope.file + ": the launch file is empty");
  check_keys(scope, root, "the launch file", {"arguments", "clock", "include", "nodes"});
}

LaunchArgument::Type type_named(const LaunchScope& scope, const YAML::Node& node) {
  const std::string name = node.as<std::string>();
  if (name == "string") return LaunchArgument::Type::kString;
  if (name == "int") return LaunchArgument::Type::kInteger;
  if (name == "double") return LaunchArgument::Type::kNumber;
  if (name == "bool") return LaunchArgument::Type::kBool;
  fail(scope, node,
       "unknown argument type \"" + name + "\"" +
           nearest_match_hint(name, {"string", "int", "double", "bool"}));
}

LaunchArgument argument_of(const LaunchScope& scope, const YAML::Node& key,
                           const YAML::Node& value) {
  LaunchArgument argument;
  argument.name = key.as<std::string>();
  if (scope.values.count(argument.name) > 0) {
    fail(scope, key, "argument " + argument.name + " has a name that is already taken");
  }
  if (value.IsNull()) return argument;
  check_keys(scope, value, "argument " + argument.name, {"default", "type", "description"});
  if (value["type"]) argument.type = type_named(scope, value["type"]);
  if (value["description"]) argument.description = value["description"].as<std::string>();
  if (value["default"]) {
    argument.default_value = text_of(scope, value["default"], "default of " + argument.name);
    check_type(scope, value["default"], argument, *argument.default_value);
  }
  return argument;
}

// Gives every declared argument its value; `given_at` is where given values come from.
void take_arguments(LaunchScope& scope, const YAML::Node& root,
                    const std::map<std::string, std::string>& given, const std::string& given_at) {
  std::vector<std::string> declared;
  const YAML::Node list = root["arguments"];
  if (list && !list.IsNull() && !list.IsMap()) {
    fail(scope, list, "arguments must be a mapping of names to {default, type, description}");
  }
  for (const auto& entry : list) {
    const LaunchArgument argument = argument_of(scope, entry.first, entry.second);
    declared.push_back(argument.name);
    const auto value = given.find(argument.name);
    if (value != given.end()) {
      check_type(scope, entry.first, argument, value->second);
      scope.values[argument.name] = value->second;
    } else if (argument.default_value) {
      scope.values[argument.name] = *argument.default_value;
    } else {
      const std::string why = argument.description.empty() ? "" : " (" + argument.description + ")";
      fail(scope, entry.first,
           "argument " + argument.name + why + " needs a value: " + argument.name + ":=...");
    }
  }
  for (const auto& [name, value] : given) {
    if (std::find(declared.begin(), declared.end(), name) != declared.end()) continue;
    throw LaunchError(given_at + ": " + scope.file + " has no argument \"" + name + "\"" +
                      nearest_match_hint(name, declared));
  }
}

std::string clock_of(const LaunchScope& scope, const YAML::Node& node,
                     const std::string& inherited) {
  if (!node) return inherited;
  const std::string clock = text_of(scope, node, "clock");
  if (clock != "wall" && clock != "simulated") {
    fail(scope, node,
         "clock must be wall or simulated, is \"" + clock + "\"" +
             nearest_match_hint(clock, {"wall", "simulated"}));
  }
  return clock;
}

std::vector<std::string> programs_in(const std::string& folder) {
  std::vector<std::string> programs;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    const bool executable =
        (entry.status(error).permissions() & fs::perms::owner_exec) != fs::perms::none;
    const bool other = name == "prehend" || name.starts_with("test_") ||
                       name.starts_with("bench_") || name.starts_with("eval_");
    if (entry.is_regular_file(error) && executable && !other) programs.push_back(name);
  }
  std::sort(programs.begin(), programs.end());
  return programs;
}

std::string file_beside(const LaunchScope& scope, const YAML::Node& node, const std::string& what) {
  const fs::path path = text_of(scope, node, what);
  const fs::path full = (fs::path(scope.values.at("launch_dir")) / path).lexically_normal();
  if (!fs::is_regular_file(full)) fail(scope, node, what + " " + full.string() + " does not exist");
  return full.string();
}

void check_name(const LaunchScope& scope, const YAML::Node& place, const std::string& name) {
  const bool right = !name.empty() && !std::isdigit(static_cast<unsigned char>(name[0])) &&
                     std::all_of(name.begin(), name.end(),
                                 [](unsigned char c) { return std::isalnum(c) || c == '_'; });
  if (!right) {
    fail(scope, place, "\"" + name + "\" is no node name: letters, digits and '_' are allowed");
  }
}

LaunchNode node_of(const LaunchScope& scope, const YAML::Node& entry, const std::string& clock,
                   const std::string& node_folder) {
  LaunchNode node;
  node.program = text_of(scope, entry["node"], "node");
  node.executable = (fs::path(node_folder) / node.program).string();
  const bool plain = node.program.find('/') == std::string::npos && !node.program.empty();
  if (!plain || !fs::is_regular_file(node.executable)) {
    fail(scope, entry["node"],
         "there is no node program \"" + node.program + "\" in " + node_folder +
             nearest_match_hint(node.program, programs_in(node_folder)));
  }
  node.place = place_of(scope, entry);
  node.name = entry["name"] ? text_of(scope, entry["name"], "name") : node.program;
  check_name(scope, entry, node.name);
  node.clock = clock_of(scope, entry["clock"], clock);
  if (entry["parameters"]) node.parameters = text_map_of(scope, entry["parameters"], "parameters");
  if (entry["parameter_file"] && !text_of(scope, entry["parameter_file"], "").empty()) {
    node.parameter_file = file_beside(scope, entry["parameter_file"], "parameter_file");
  }
  if (entry["remap"]) node.remaps = text_map_of(scope, entry["remap"], "remap");
  for (const auto& [from, to] : node.remaps) {
    if (from.starts_with('/') && to.starts_with('/')) continue;
    fail(scope, entry["remap"], "remap " + from + ": " + to + ": both names must begin with '/'");
  }
  if (entry["environment"]) {
    node.environment = text_map_of(scope, entry["environment"], "environment");
  }
  if (entry["required"]) node.required = bool_of(scope, entry["required"], "required");
  if (entry["respawn"]) node.respawn = bool_of(scope, entry["respawn"], "respawn");
  if (node.required && node.respawn) {
    fail(scope, entry, node.name + " cannot be both required and respawn");
  }
  return node;
}

class Loader {
 public:
  explicit Loader(std::string node_folder) : node_folder_(std::move(node_folder)) {}

  // Adds what `path` asks for to `graph`; returns the values of its arguments.
  std::map<std::string, std::string> load(const std::string& path,
                                          const std::map<std::string, std::string>& given,
                                          const std::string& given_at, const std::string& clock,
                                          LaunchGraph& graph) {
    LaunchScope scope = scope_of(path);
    check_cycle(scope.file, given_at);
    chain_.push_back(scope.file);
    const YAML::Node root = parse_file(scope);
    check_top_level(scope, root);
    take_arguments(scope, root, given, given_at);
    const std::string own_clock = clock_of(scope, root["clock"], clock);
    add_includes(scope, root["include"], own_clock, graph);
    add_nodes(scope, root["nodes"], own_clock, graph);
    chain_.pop_back();
    return scope.values;
  }

 private:
  void check_cycle(const std::string& file, const std::string& given_at) const {
    if (std::find(chain_.begin(), chain_.end(), file) == chain_.end()) return;
    std::string text = given_at + ": launch files include each other in a circle: ";
    for (const std::string& link : chain_) text += link + " -> ";
    throw LaunchError(text + file);
  }

  void add_includes(const LaunchScope& scope, const YAML::Node& list, const std::string& clock,
                    LaunchGraph& graph) {
    if (!list || list.IsNull()) return;
    if (!list.IsSequence())
      fail(scope, list, "include must be a list of {file: ..., arguments: ...}");
    for (const YAML::Node& entry : list) {
      check_keys(scope, entry, "an include", {"file", "arguments", "if"});
      if (!entry["file"]) fail(scope, entry, "an include needs the key \"file\"");
      if (entry["if"] && !condition_of(scope, entry["if"])) continue;
      std::map<std::string, std::string> arguments;
      if (entry["arguments"]) arguments = text_map_of(scope, entry["arguments"], "arguments");
      load(file_beside(scope, entry["file"], "included file"), arguments, place_of(scope, entry),
           clock, graph);
    }
  }

  void add_nodes(const LaunchScope& scope, const YAML::Node& list, const std::string& clock,
                 LaunchGraph& graph) {
    if (!list || list.IsNull()) return;
    if (!list.IsSequence()) fail(scope, list, "nodes must be a list of {node: ..., ...}");
    for (const YAML::Node& entry : list) {
      check_keys(scope, entry, "a node",
                 {"node", "name", "parameters", "parameter_file", "remap", "required", "respawn",
                  "if", "clock", "environment"});
      if (!entry["node"]) fail(scope, entry, "a node needs the key \"node\", its program");
      if (entry["if"] && !condition_of(scope, entry["if"])) continue;
      LaunchNode node = node_of(scope, entry, clock, node_folder_);
      for (const LaunchNode& other : graph.nodes) {
        if (other.name != node.name) continue;
        fail(scope, entry,
             "a node named \"" + node.name + "\" is already at " + other.place +
                 "; give one of them another name");
      }
      graph.nodes.push_back(std::move(node));
    }
  }

  const std::string node_folder_;
  std::vector<std::string> chain_;  // of files being read, the top one first
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
  std::vector<LaunchArgument> arguments;
  LaunchScope known = scope;
  for (const auto& entry : root["arguments"]) {
    arguments.push_back(argument_of(known, entry.first, entry.second));
    known.values[arguments.back().name] = arguments.back().default_value.value_or("");
  }
  return arguments;
}

LaunchGraph load_launch_file(const std::string& path,
                             const std::map<std::string, std::string>& arguments,
                             const std::string& node_folder) {
  LaunchGraph graph;
  graph.file = scope_of(path).file;
  Loader loader(fs::absolute(node_folder).lexically_normal().string());
  try {
    graph.arguments = loader.load(path, arguments, "command line", "", graph);
  } catch (const YAML::Exception& error) {
    throw LaunchError(graph.file + ": " + error.what());
  }
  graph.arguments.erase("launch_dir");
  graph.arguments.erase("root");
  if (graph.nodes.empty()) throw LaunchError(graph.file + ": there are no nodes to start");
  return graph;
}

std::string describe(const LaunchGraph& graph) {
  YAML::Emitter out;
  const auto map = [&](const char* key, const std::map<std::string, std::string>& entries) {
    if (!entries.empty()) out << YAML::Key << key << YAML::Value << entries;
  };
  out << YAML::Comment(graph.file);
  for (const auto& [name, value] : graph.arguments) out << YAML::Comment(name + ":=" + value);
  out << YAML::BeginMap << YAML::Key << "nodes" << YAML::Value << YAML::BeginSeq;
  for (const LaunchNode& node : graph.nodes) {
    out << YAML::BeginMap << YAML::Key << "node" << YAML::Value << node.program;
    out << YAML::Comment(node.place) << YAML::Key << "name" << YAML::Value << node.name;
    if (!node.clock.empty()) out << YAML::Key << "clock" << YAML::Value << node.clock;
    map("parameters", node.parameters);
    if (!node.parameter_file.empty()) {
      out << YAML::Key << "parameter_file" << YAML::Value << node.parameter_file;
    }
    map("remap", node.remaps);
    map("environment", node.environment);
    if (node.required) out << YAML::Key << "required" << YAML::Value << true;
    if (node.respawn) out << YAML::Key << "respawn" << YAML::Value << true;
    out << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

std::vector<std::string> command_line(const LaunchNode& node) {
  std::vector<std::string> words{node.executable, "--name", node.name};
  if (!node.clock.empty()) words.insert(words.end(), {"--clock", node.clock});
  if (!node.parameter_file.empty()) words.insert(words.end(), {"--params", node.parameter_file});
  for (const auto& [key, value] : node.parameters) {
    words.insert(words.end(), {"--param", key + ":=" + value});
  }
  for (const auto& [from, to] : node.remaps) {
    words.insert(words.end(), {"--remap", from + ":=" + to});
  }
  return words;
}

}  // namespace prehend::graph::launch
