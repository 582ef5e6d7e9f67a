#include "nodes/report/processes.h"

#include <fstream>
#include <sstream>
#include <stdexcept>

#include <unistd.h>

#include "prehend/graph/introspection.h"

namespace prehend::nodes {
namespace {

// "VmHWM:   123 kB" of /proc/PID/status; 0 when the process is gone.
double peak_memory(int pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  std::string line;
  while (std::getline(status, line)) {
    if (line.rfind("VmHWM:", 0) != 0) continue;
    return 1024 * std::stod(line.substr(6));
  }
  return 0;
}

// Fields 14 and 15 of /proc/PID/stat, after the name in parentheses (proc(5)).
double cpu_time(int pid) {
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string line;
  std::getline(stat, line);
  const auto name_end = line.rfind(')');
  if (name_end == std::string::npos) return 0;
  std::istringstream fields(line.substr(name_end + 1));
  std::string skipped;
  for (int i = 3; i < 14; ++i) fields >> skipped;
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

}  // namespace

std::vector<Process> list_processes() {
  std::vector<Process> out;
  try {
    graph::Introspection introspection;
    for (const auto& node : introspection.nodes()) {
      const int pid = static_cast<int>(node.pid());
      const double memory = peak_memory(pid);
      if (memory > 0) out.push_back({node.name(), pid, memory, cpu_time(pid)});
    }
  } catch (const std::runtime_error&) {
    out.clear();  // the registry went away; the report says that there is no table
  }
  return out;
}

}  // namespace prehend::nodes
