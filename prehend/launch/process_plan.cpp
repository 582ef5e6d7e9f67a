#include "prehend/launch/process_plan.h"

#include <sched.h>

#include <algorithm>
#include <filesystem>
#include <set>

namespace prehend::launch {
namespace {

const std::string& process_name(const LaunchNode& node) {
  return node.process.empty() ? node.name : node.process;
}

// Nodes of one process must agree in what is the process'.
void check_agreement(const LaunchNode& first, const LaunchNode& second) {
  const char* key = first.host != second.host                   ? "host"
                    : first.required != second.required         ? "required"
                    : !(first.respawn == second.respawn)        ? "respawn"
                    : first.environment != second.environment   ? "environment"
                    : first.cpu_affinity != second.cpu_affinity ? "cpu_affinity"
                    : first.nice != second.nice                 ? "nice"
                                                                : nullptr;
  if (!key) return;
  throw LaunchError(second.place + ": " + second.name + " shares the process \"" + second.process +
                    "\" with " + first.name + " (" + first.place + ") but differs in \"" + key +
                    "\", which is of the process as a whole; give both the same");
}

using ByName = std::map<std::string, const LaunchNode*>;

ByName nodes_by_name(const LaunchGraph& graph) {
  ByName nodes;
  for (const LaunchNode& node : graph.nodes) nodes[node.name] = &node;
  return nodes;
}

// Finds circles in which processes wait for each other.
class StartOrder {
 public:
  explicit StartOrder(const LaunchGraph& graph) : nodes_(nodes_by_name(graph)) {
    for (const LaunchNode& node : graph.nodes) members_[process_name(node)].push_back(&node);
  }

  void check() {
    for (const auto& [process, members] : members_) visit(process);
  }

 private:
  void visit(const std::string& process) {
    if (done_.count(process) > 0) return;
    path_.push_back(process);
    for (const LaunchNode* node : members_.at(process)) {
      for (const std::string& name : node->after) {
        const std::string& next = process_name(*nodes_.at(name));
        if (next == process) refuse_own(*node, name);
        const auto seen = std::find(path_.begin(), path_.end(), next);
        if (seen != path_.end()) refuse_circle(*node, seen);
        visit(next);
      }
    }
    path_.pop_back();
    done_.insert(process);
  }

  static void refuse_own(const LaunchNode& node, const std::string& name) {
    if (node.name == name) throw LaunchError(node.place + ": " + name + " is after itself");
    throw LaunchError(node.place + ": " + node.name + " cannot start after " + name +
                      ": both are in the process \"" + node.process + "\"");
  }

  void refuse_circle(const LaunchNode& node, std::vector<std::string>::const_iterator from) const {
    std::string circle;
    for (auto link = from; link != path_.end(); ++link) circle += *link + " after ";
    throw LaunchError(node.place + ": nodes wait for each other in a circle: " + circle + *from);
  }

  const ByName nodes_;
  std::map<std::string, std::vector<const LaunchNode*>> members_;
  std::vector<std::string> path_;
  std::set<std::string> done_;
};

void check_cpus(const LaunchNode& node) {
  cpu_set_t available;
  CPU_ZERO(&available);
  if (node.cpu_affinity.empty() || ::sched_getaffinity(0, sizeof available, &available) != 0)
    return;
  for (const int cpu : node.cpu_affinity) {
    if (CPU_ISSET(cpu, &available)) continue;
    std::string list;
    for (int i = 0; i < CPU_SETSIZE; ++i) {
      if (CPU_ISSET(i, &available)) list += (list.empty() ? "" : ", ") + std::to_string(i);
    }
    throw LaunchError(node.place + ": cpu_affinity of " + node.name + ": CPU " +
                      std::to_string(cpu) + " is not available; there are " + list);
  }
}

std::vector<std::string> command_of(const std::vector<const LaunchNode*>& nodes,
                                    const std::string& address) {
  const LaunchNode& first = *nodes.front();
  std::vector<std::string> words;
  if (first.process.empty()) {
    words = node_options(first, address);
    words.insert(words.begin(), first.executable);
    return words;
  }
  const auto folder = std::filesystem::path(first.executable).parent_path();
  words.push_back((folder / "container").string());
  for (const LaunchNode* node : nodes) {
    words.insert(words.end(), {"--", node->program});
    const auto options = node_options(*node, address);
    words.insert(words.end(), options.begin(), options.end());
  }
  return words;
}

}  // namespace

void check_processes(const LaunchGraph& graph) {
  const ByName nodes = nodes_by_name(graph);
  std::map<std::string, const LaunchNode*> first_of;
  for (const LaunchNode& node : graph.nodes) {
    if (node.process.empty()) continue;
    check_agreement(*first_of.emplace(node.process, &node).first->second, node);
    if (const auto other = nodes.find(node.process); other != nodes.end()) {
      throw LaunchError(node.place + ": compose: a node is named \"" + node.process + "\" too (" +
                        other->second->place + "); give the process another name");
    }
  }
  StartOrder(graph).check();
}

std::vector<LaunchProcess> processes_of(const LaunchGraph& graph, const std::string& host) {
  std::string address;
  for (const LaunchHost& other : graph.hosts) {
    if (other.name == host) address = other.address;
  }
  std::vector<LaunchProcess> processes;
  for (const LaunchNode& node : graph.nodes) {
    if (node.host != host) continue;
    check_cpus(node);
    const auto same = std::find_if(processes.begin(), processes.end(), [&](const auto& process) {
      return process.name == process_name(node);
    });
    if (same != processes.end()) {
      same->nodes.push_back(&node);
      continue;
    }
    LaunchProcess process;
    process.name = process_name(node);
    process.nodes = {&node};
    process.environment = node.environment;
    process.share = {node.cpu_affinity, node.nice};
    process.required = node.required;
    process.respawn = node.respawn;
    processes.push_back(std::move(process));
  }
  for (LaunchProcess& process : processes) {
    for (const LaunchNode* node : process.nodes) {
      process.after.insert(process.after.end(), node->after.begin(), node->after.end());
      if (node->stop_time) process.stop_time = std::max(process.stop_time, node->stop_time);
    }
    process.command = command_of(process.nodes, address);
  }
  return processes;
}

}  // namespace prehend::launch
