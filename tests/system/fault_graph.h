#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/system/launched.h"
#include "tests/system/traffic_state.h"

namespace prehend::testing {

/// A graph of real processes that can be killed and started again: a registry at a port of its own,
/// and any of publishers, subscribers (traffic_node) and a recorder. Its runtime folder, output and
/// recordings are in one scratch folder. Nothing of it outlives it.
class FaultGraph {
 public:
  FaultGraph();
  ~FaultGraph();

  const std::filesystem::path& folder() const { return scratch_.path(); }
  const std::string& registry_endpoint() const { return endpoint_; }
  /// XDG_RUNTIME_DIR of all processes.
  std::filesystem::path runtime_base() const { return folder() / "run"; }

  void start_registry();
  /// A publisher's `index` is below kSenders.
  void start_publisher(const std::string& name, int index);
  void start_subscriber(const std::string& name);
  /// Records all topics into a new file each time.
  void start_recorder(const std::string& name);

  /// The processes' names, sorted.
  std::vector<std::string> names() const;
  pid_t pid(const std::string& name) const { return processes_.at(name).process->pid(); }
  std::string output(const std::string& name) const {
    return processes_.at(name).process->output();
  }
  /// What a publisher or subscriber told last.
  TrafficState& state(const std::string& name) { return **processes_.at(name).state; }
  std::filesystem::path recording(const std::string& name) const {
    return processes_.at(name).recording;
  }
  std::vector<std::string> publishers() const;
  std::vector<std::string> subscribers() const;

  void send_signal(const std::string& name, int signal);
  /// SIGKILL, and waits for the end.
  void kill(const std::string& name);
  /// Starts a process again the way it was started.
  void restart(const std::string& name);
  /// SIGINT and waits; the exit code as in Launched::wait.
  std::optional<int> stop(const std::string& name);

 private:
  struct Process {
    std::unique_ptr<Launched> process;
    std::unique_ptr<TrafficFile> state;
    std::filesystem::path recording;
    std::function<void()> start;
    int index = -1;        // of a publisher
    bool listens = false;  // a subscriber
  };

  void launch(const std::string& name, const std::string& program,
              std::vector<std::string> arguments);

  ScratchFolder scratch_;
  std::string endpoint_;
  std::map<std::string, Process> processes_;
  int starts_ = 0;
};

}  // namespace prehend::testing
