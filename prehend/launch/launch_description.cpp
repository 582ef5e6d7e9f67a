#include <yaml-cpp/yaml.h>

#include "prehend/launch/launch_file.h"
#include "prehend/launch/launch_node.h"

// A resolved launch as text: YAML for people, options for programs.
namespace prehend::launch {
namespace {

void put(YAML::Emitter& out, const char* key, const std::string& text) {
  if (!text.empty()) out << YAML::Key << key << YAML::Value << text;
}

void put(YAML::Emitter& out, const char* key, const std::map<std::string, std::string>& entries) {
  if (!entries.empty()) out << YAML::Key << key << YAML::Value << entries;
}

template <class Item>
void put(YAML::Emitter& out, const char* key, const std::vector<Item>& items) {
  if (!items.empty()) out << YAML::Key << key << YAML::Value << YAML::Flow << items;
}

void put_respawn(YAML::Emitter& out, const Respawn& respawn) {
  if (!respawn.wanted) return;
  out << YAML::Key << "respawn" << YAML::Value << YAML::Flow << YAML::BeginMap;
  out << YAML::Key << "first_delay" << YAML::Value << respawn.first_delay;
  out << YAML::Key << "longest_delay" << YAML::Value << respawn.longest_delay << YAML::EndMap;
}

void put_hosts(YAML::Emitter& out, const LaunchGraph& graph) {
  if (graph.hosts.empty()) return;
  out << YAML::Key << "hosts" << YAML::Value << YAML::BeginMap;
  for (const LaunchHost& host : graph.hosts) {
    out << YAML::Key << host.name << YAML::Value << YAML::Flow << YAML::BeginMap << YAML::Key
        << "address" << YAML::Value << host.address << YAML::EndMap;
  }
  out << YAML::EndMap;
  put(out, "registry_host", graph.registry_host);
}

void put_warnings(YAML::Emitter& out, const LaunchGraph& graph) {
  if (graph.warnings.empty()) return;
  out << YAML::Key << "warnings" << YAML::Value << YAML::BeginSeq;
  for (const std::string& text : graph.warnings) {
    out << YAML::BeginMap << YAML::Key << "text" << YAML::Value << text << YAML::EndMap;
  }
  out << YAML::EndSeq;
}

// Names are written as they were before the namespace was added.
std::map<std::string, std::string> remaps_as_written(const LaunchNode& node) {
  auto remaps = node.remaps;
  for (auto& [from, to] : remaps) to = "/" + to;  // "//": of the whole graph
  return node.name_space.empty() ? node.remaps : remaps;
}

void put_node(YAML::Emitter& out, const LaunchNode& node) {
  out << YAML::BeginMap << YAML::Key << "node" << YAML::Value
      << (node.by_path ? node.executable : node.program);
  out << YAML::Comment(node.place);
  put(out, "name", node.name.substr(name_in(node.name_space, "").size()));
  put(out, "namespace", node.name_space);
  put(out, "host", node.host);
  put(out, "compose", node.process);
  put(out, "clock", node.clock);
  put(out, "parameters", node.parameters);
  put(out, "parameter_file", node.parameter_file);
  put(out, "remap", remaps_as_written(node));
  put(out, "environment", node.environment);
  put(out, "cpu_affinity", node.cpu_affinity);
  if (node.nice != 0) out << YAML::Key << "nice" << YAML::Value << node.nice;
  put(out, "after", node.after);
  if (node.required) out << YAML::Key << "required" << YAML::Value << true;
  put_respawn(out, node.respawn);
  if (node.stop_time) out << YAML::Key << "stop_time" << YAML::Value << *node.stop_time;
  out << YAML::EndMap;
}

}  // namespace

std::string describe(const LaunchGraph& graph) {
  YAML::Emitter out;
  out << YAML::Comment(graph.file);
  for (const auto& [name, value] : graph.arguments) out << YAML::Comment(name + ":=" + value);
  out << YAML::BeginMap;
  put_hosts(out, graph);
  put(out, "log_directory", graph.log_directory);
  put_warnings(out, graph);
  out << YAML::Key << "nodes" << YAML::Value << YAML::BeginSeq;
  for (const LaunchNode& node : graph.nodes) put_node(out, node);
  out << YAML::EndSeq << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

std::vector<std::string> node_options(const LaunchNode& node, const std::string& address) {
  std::vector<std::string> words{"--name", node.name};
  const auto add = [&words](const char* option, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {option, value});
  };
  add("--namespace", node.name_space);
  add("--bind", address);
  add("--clock", node.clock);
  add("--params", node.parameter_file);
  for (const auto& [key, value] : node.parameters) add("--param", key + ":=" + value);
  for (const auto& [from, to] : node.remaps) add("--remap", from + ":=" + to);
  return words;
}

}  // namespace prehend::launch
