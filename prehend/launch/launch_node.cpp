#include "prehend/launch/launch_node.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <stdexcept>

#include "prehend/graph/names.h"
#include "prehend/text/nearest_match.h"

namespace prehend::launch {
namespace {

namespace fs = std::filesystem;

constexpr double kShortestDelay = 0.05;  // s, of a respawn
constexpr double kLongestDelay = 3600;
constexpr double kLongestStop = 3600;
constexpr int kMostCpus = 1024;

std::string clock_of(const LaunchScope& scope, const YAML::Node& node) {
  const std::string clock = text_of(scope, node, "clock");
  if (clock != "wall" && clock != "simulated" && !is_open(clock)) {
    fail(scope, node,
         "clock must be wall or simulated, is \"" + clock + "\"" +
             text::nearest_match_hint(clock, {"wall", "simulated"}));
  }
  return clock;
}

void check_resource(const LaunchScope& scope, const YAML::Node& place, const std::string& what,
                    const std::string& name) {
  if (is_open(name)) return;
  if (!name.starts_with('/')) fail(scope, place, what + ": names must begin with '/'");
  try {
    graph::check_resource_name(name);
  } catch (const std::invalid_argument& error) {
    fail(scope, place, what + ": " + error.what());
  }
}

std::string name_space_of(const LaunchScope& scope, const YAML::Node& node,
                          const std::string& outer) {
  const std::string name_space = text_of(scope, node, "namespace");
  if (name_space.empty()) return outer;
  check_resource(scope, node, "namespace", name_space);
  return outer + name_space;
}

std::string host_of(const LaunchScope& scope, const YAML::Node& node,
                    const std::vector<LaunchHost>& hosts) {
  const std::string host = text_of(scope, node, "host");
  std::vector<std::string> known;
  for (const LaunchHost& other : hosts) known.push_back(other.name);
  if (host.empty() || is_open(host)) return "";
  if (hosts.empty()) {
    fail(scope, node,
         "host " + host + ": the launched file has no hosts: {" + host + ": {address: ...}}");
  }
  if (std::find(known.begin(), known.end(), host) == known.end()) {
    fail(scope, node, "unknown host \"" + host + "\"" + text::nearest_match_hint(host, known));
  }
  return host;
}

// compose: NAME, or {name: NAME, if: CONDITION}; "" is a process for each node.
std::string process_of(const LaunchScope& scope, const YAML::Node& node,
                       const std::string& inherited) {
  YAML::Node name = node;
  if (node.IsMap()) {
    check_keys(scope, node, "compose", {"name", "if"});
    if (!node["name"]) fail(scope, node, "compose needs the key \"name\"");
    if (!condition_of(scope, node["if"])) return inherited;
    name.reset(node["name"]);
  }
  const std::string process = text_of(scope, name, "compose");
  if (!process.empty()) check_name(scope, name, process, "process");
  return process;
}

std::vector<int> cpus_of(const LaunchScope& scope, const YAML::Node& node) {
  std::vector<int> cpus;
  for (const std::string& text : text_list_of(scope, node, "cpu_affinity")) {
    if (is_open(text)) return {};
    int cpu = -1;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, cpu);
    if (error != std::errc() || stop != end || cpu < 0 || cpu >= kMostCpus) {
      fail(scope, node,
           "cpu_affinity must be a list of CPU numbers like [0, 1], has \"" + text + "\"");
    }
    if (std::find(cpus.begin(), cpus.end(), cpu) == cpus.end()) cpus.push_back(cpu);
  }
  std::sort(cpus.begin(), cpus.end());
  return cpus;
}

int nice_of(const LaunchScope& scope, const YAML::Node& node) {
  constexpr int kMostNice = 19;  // nice(1)
  const double nice = number_of(scope, node, "nice", kMostNice, 0);
  if (nice != std::floor(nice)) fail(scope, node, "nice must be a whole number, 0 to 19");
  return static_cast<int>(nice);
}

Respawn respawn_of(const LaunchScope& scope, const YAML::Node& node) {
  Respawn respawn;
  if (!node) return respawn;
  if (!node.IsMap()) {
    respawn.wanted = bool_of(scope, node, "respawn");
    return respawn;
  }
  check_keys(scope, node, "respawn", {"first_delay", "longest_delay"});
  respawn.wanted = true;
  respawn.first_delay =
      number_of(scope, node["first_delay"], "first_delay [s]", kLongestDelay, respawn.first_delay);
  respawn.longest_delay =
      number_of(scope, node["longest_delay"], "longest_delay [s]", kLongestDelay,
                std::max(respawn.longest_delay, respawn.first_delay));
  if (respawn.first_delay < kShortestDelay) {
    fail(scope, node, "respawn: first_delay must be at least 0.05 s");
  }
  if (respawn.longest_delay < respawn.first_delay) {
    fail(scope, node, "respawn: longest_delay is shorter than first_delay");
  }
  return respawn;
}

bool is_executable_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) &&
         (fs::status(path, error).permissions() & fs::perms::owner_exec) != fs::perms::none;
}

std::vector<std::string> folders_of(const std::string& path) {
  std::vector<std::string> folders;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find(':', begin), path.size());
    if (end > begin) folders.push_back(path.substr(begin, end - begin));
    begin = end + 1;
  }
  return folders;
}

std::vector<std::string> programs_in(const std::vector<std::string>& folders) {
  std::vector<std::string> programs;
  std::error_code error;
  for (const std::string& folder : folders) {
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      const std::string name = entry.path().filename().string();
      const bool other = name == "prehend" || name == "registry" || name == "container" ||
                         name.starts_with("test_") || name.starts_with("bench_") ||
                         name.starts_with("eval_");
      if (is_executable_file(entry.path()) && !other) programs.push_back(name);
    }
  }
  std::sort(programs.begin(), programs.end());
  return programs;
}

// The executable of a program that is named by its path, seen from the launch file.
std::string executable_at(const LaunchScope& scope, const YAML::Node& place,
                          const std::string& path) {
  const fs::path full = (fs::path(scope.values.at("launch_dir")) / path).lexically_normal();
  if (!fs::is_regular_file(full)) {
    fail(scope, place, "there is no node program " + full.string());
  }
  if (!is_executable_file(full)) {
    fail(scope, place, "node program " + full.string() + " is not executable; run: chmod +x");
  }
  return full.string();
}

// The executable of a program that is named alone, in the first folder that has it.
std::string executable_in(const LaunchScope& scope, const YAML::Node& place,
                          const std::string& node_path, const std::string& name) {
  const std::vector<std::string> folders = folders_of(node_path);
  std::string all;
  for (const std::string& folder : folders) {
    const fs::path file = (fs::absolute(folder) / name).lexically_normal();
    if (!name.empty() && fs::is_regular_file(file)) return file.string();
    all += (all.empty() ? "" : " or ") + folder;
  }
  fail(scope, place,
       "there is no node program \"" + name + "\" in " + all +
           text::nearest_match_hint(name, programs_in(folders)) +
           "; programs elsewhere are named by their path or found in PREHEND_NODE_PATH");
}

void take_program(const LaunchScope& scope, const YAML::Node& entry, const std::string& node_path,
                  LaunchNode& node) {
  const std::string program = text_of(scope, entry["node"], "node");
  node.by_path = program.find('/') != std::string::npos;
  node.program = fs::path(program).filename().string();
  if (node.program == "registry") {
    fail(scope, entry["node"], "every launch has a registry of its own; remove this one");
  }
  node.executable = node.by_path ? executable_at(scope, entry["node"], program)
                                 : executable_in(scope, entry["node"], node_path, program);
}

// A new name begins with "//" when it shall not be in the node's namespace.
std::map<std::string, std::string> remaps_of(const LaunchScope& scope, const YAML::Node& list,
                                             const std::string& name_space) {
  std::map<std::string, std::string> remaps = text_map_of(scope, list, "remap", Values::kSingle);
  // What a prefix that may be empty leaves as it is, unless it keeps a name from a remap of all
  // there.
  for (auto remap = remaps.begin(); remap != remaps.end();) {
    auto others = remaps;
    others.erase(remap->first);
    const bool does_nothing =
        remap->first == remap->second && graph::remap_of(others, remap->first) == others.end();
    remap = does_nothing ? remaps.erase(remap) : std::next(remap);
  }
  for (auto& [from, to] : remaps) {
    const std::string what = "remap " + from + ": " + to;
    const bool whole_graph = to.starts_with("//");
    if (whole_graph) to.erase(0, 1);
    if (!is_open(from) && !is_open(to)) {
      try {
        graph::check_remap(from, to);
      } catch (const std::invalid_argument& error) {
        fail(scope, list, what + ": " + error.what());
      }
    }
    if (!whole_graph) to = graph::in_name_space(name_space, to);
  }
  return remaps;
}

std::map<std::string, std::string> environment_of(const LaunchScope& scope,
                                                  const YAML::Node& list) {
  const auto environment = text_map_of(scope, list, "environment", Values::kSingle);
  for (const auto& [name, value] : environment) {
    if (name.find('=') != std::string::npos) {
      fail(scope, list, "environment: \"" + name + "\" is no name of a variable");
    }
  }
  return environment;
}

}  // namespace

std::vector<std::string> setting_keys() {
  return {"clock", "namespace", "host", "compose", "environment", "cpu_affinity", "nice"};
}

LaunchSettings settings_of(const LaunchScope& scope, const YAML::Node& entry,
                           const LaunchSettings& inherited, const std::vector<LaunchHost>& hosts) {
  LaunchSettings settings = inherited;
  if (entry["clock"]) settings.clock = clock_of(scope, entry["clock"]);
  if (entry["namespace"]) {
    settings.name_space = name_space_of(scope, entry["namespace"], inherited.name_space);
  }
  if (entry["host"]) settings.host = host_of(scope, entry["host"], hosts);
  if (entry["compose"]) settings.process = process_of(scope, entry["compose"], inherited.process);
  for (const auto& [name, value] : environment_of(scope, entry["environment"])) {
    settings.environment[name] = value;
  }
  if (entry["cpu_affinity"]) settings.cpu_affinity = cpus_of(scope, entry["cpu_affinity"]);
  if (entry["nice"]) settings.nice = nice_of(scope, entry["nice"]);
  return settings;
}

std::string name_in(const std::string& name_space, const std::string& name) {
  if (name_space.empty()) return name;
  std::string prefix = name_space.substr(1) + "_";
  std::replace(prefix.begin(), prefix.end(), '/', '_');
  return prefix + name;
}

std::string node_name_of(const LaunchScope& scope, const YAML::Node& entry,
                         const LaunchSettings& settings) {
  std::string name = text_of(scope, entry[entry["name"] ? "name" : "node"], "name");
  if (!entry["name"] && !is_open(name)) name = fs::path(name).stem().string();
  check_name(scope, entry[entry["name"] ? "name" : "node"], name, "node");
  return name_in(settings.name_space, name);
}

LaunchNode node_of(const LaunchScope& scope, const YAML::Node& entry,
                   const LaunchSettings& settings, const std::string& node_path) {
  LaunchNode node;
  take_program(scope, entry, node_path, node);
  node.place = place_of(scope, entry);
  node.name = node_name_of(scope, entry, settings);
  node.clock = settings.clock;
  node.name_space = settings.name_space;
  node.host = settings.host;
  node.process = settings.process;
  node.environment = settings.environment;
  node.cpu_affinity = settings.cpu_affinity;
  node.nice = settings.nice;
  node.parameters = text_map_of(scope, entry["parameters"], "parameters", Values::kSingleOrLists,
                                &node.parameter_places);
  if (!text_of(scope, entry["parameter_file"], "parameter_file").empty()) {
    node.parameter_file = file_beside(scope, entry["parameter_file"], "parameter_file");
  }
  node.remaps = remaps_of(scope, entry["remap"], settings.name_space);
  node.after = text_list_of(scope, entry["after"], "after");
  if (entry["required"]) node.required = bool_of(scope, entry["required"], "required");
  node.respawn = respawn_of(scope, entry["respawn"]);
  if (node.required && node.respawn.wanted) {
    fail(scope, entry, node.name + " cannot be both required and respawn");
  }
  if (entry["stop_time"]) {
    node.stop_time = number_of(scope, entry["stop_time"], "stop_time [s]", kLongestStop, 0);
  }
  return node;
}

std::string file_beside(const LaunchScope& scope, const YAML::Node& node, const std::string& what) {
  const fs::path path = text_of(scope, node, what);
  if (is_open(path.string())) return "";
  const fs::path full = (fs::path(scope.values.at("launch_dir")) / path).lexically_normal();
  if (!fs::is_regular_file(full)) fail(scope, node, what + " " + full.string() + " does not exist");
  return full.string();
}

void check_name(const LaunchScope& scope, const YAML::Node& place, const std::string& name,
                const std::string& what) {
  if (is_open(name)) return;
  const bool right = !name.empty() && name.size() <= 100 &&
                     !std::isdigit(static_cast<unsigned char>(name[0])) &&
                     std::all_of(name.begin(), name.end(),
                                 [](unsigned char c) { return std::isalnum(c) || c == '_'; });
  if (!right) {
    fail(scope, place,
         "\"" + name + "\" is no " + what + " name: letters, digits and '_' are allowed");
  }
  if (name == "launch" || name == "registry") {
    fail(scope, place, "the " + what + " name \"" + name + "\" is the launch's own; take another");
  }
}

}  // namespace prehend::launch
