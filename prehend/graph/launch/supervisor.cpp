#include "prehend/graph/launch/supervisor.h"

#include <fmt/core.h>
#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "prehend/graph/introspection.h"
#include "prehend/graph/launch/supervised_process.h"
#include "prehend/graph/nearest_match.h"
#include "prehend/graph/node.h"

namespace prehend::graph::launch {
namespace {

using Clock = SupervisedProcess::Clock;
using std::chrono::milliseconds;

constexpr milliseconds kReadyPoll{50};         // between questions to the registry
constexpr milliseconds kRegistryTimeout{300};  // of one question
constexpr milliseconds kRegistryStart{5000};
constexpr milliseconds kRegistryStop{1000};
constexpr const char* kRegistryName = "registry";
constexpr const char* kListens = "listens on ";

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// SIGINT, SIGTERM, SIGHUP and SIGCHLD as something to poll.
class SignalSource {
 public:
  SignalSource() {
    sigset_t signals;
    ::sigemptyset(&signals);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGCHLD}) ::sigaddset(&signals, signal);
    ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    file_ = ::signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
    if (file_ < 0) throw std::system_error(errno, std::generic_category(), "signalfd");
  }
  ~SignalSource() { ::close(file_); }
  SignalSource(const SignalSource&) = delete;
  SignalSource& operator=(const SignalSource&) = delete;

  int file() const { return file_; }
  // The next signal that asks to stop, 0 when there is none.
  int take_stop() {
    signalfd_siginfo info;
    while (::read(file_, &info, sizeof info) == sizeof info) {
      if (info.ssi_signo != SIGCHLD) return static_cast<int>(info.ssi_signo);
    }
    return 0;
  }

 private:
  int file_ = -1;
};

std::vector<std::string> names_of(const LaunchGraph& graph) {
  std::vector<std::string> names{kRegistryName};
  for (const LaunchNode& node : graph.nodes) names.push_back(node.name);
  return names;
}

class Supervisor {
 public:
  Supervisor(const LaunchGraph& graph, const SupervisorOptions& options)
      : graph_(graph), options_(options), output_(options.log_folder, names_of(graph)) {}

  int run() {
    output_.progress(
        fmt::format("{}: {}, logs in {}", graph_.file, nodes_text(), options_.log_folder));
    start_registry();
    if (!exit_code_) start_nodes();
    while (!exit_code_) step();
    stop_all();
    return *exit_code_;
  }

 private:
  struct Member {
    const LaunchNode* node;
    SupervisedProcess process;
  };

  std::string nodes_text() const {
    return std::to_string(graph_.nodes.size()) + (graph_.nodes.size() == 1 ? " node" : " nodes");
  }

  // --- starting ----------------------------------------------------------------------------------

  void start_registry() {
    const bool free_choice = options_.registry.empty();
    if (listen(free_choice ? kDefaultRegistryEndpoint : options_.registry)) return;
    if (exit_code_) return;
    if (free_choice) output_.progress("taking a free port for the registry instead");
    if (free_choice && listen("tcp://127.0.0.1:*")) return;
    if (!exit_code_) throw std::runtime_error("the registry did not start; its words are above");
  }

  // True once a registry listens at `endpoint`.
  bool listen(const std::string& endpoint) {
    registry_ = std::make_unique<SupervisedProcess>(
        kRegistryName, std::vector<std::string>{options_.registry_program, "--registry", endpoint},
        std::map<std::string, std::string>{}, output_);
    registry_->start();
    const auto deadline = Clock::now() + kRegistryStart;
    while (!exit_code_ && registry_->running() && Clock::now() < deadline) {
      wait_for_events({registry_.get()}, deadline);
      registry_->forward_output();
      const std::string& line = registry_->last_line();
      if (const auto at = line.find(kListens); at != std::string::npos) {
        endpoint_ = line.substr(at + std::string(kListens).size());
        return true;
      }
      registry_->reap();
      if (const int signal = signals_.take_stop()) stop_for(signal);
    }
    return false;
  }

  void start_nodes() {
    for (const LaunchNode& node : graph_.nodes) {
      std::map<std::string, std::string> environment = node.environment;
      environment["PREHEND_REGISTRY"] = endpoint_;
      members_.push_back(std::make_unique<Member>(
          Member{&node, SupervisedProcess(node.name, command_line(node), environment, output_)}));
    }
    for (const auto& member : members_) member->process.start();
    started_ = Clock::now();
    introspection_ = std::make_unique<Introspection>(endpoint_, kRegistryTimeout);
  }

  // --- running -----------------------------------------------------------------------------------

  void step() {
    auto deadline = Clock::now() + std::chrono::seconds(1);
    if (introspection_ && !all_ready_) deadline = Clock::now() + kReadyPoll;
    std::vector<SupervisedProcess*> processes{registry_.get()};
    for (const auto& member : members_) {
      processes.push_back(&member->process);
      if (member->process.restart_at) deadline = std::min(deadline, *member->process.restart_at);
    }
    if (registry_->restart_at) deadline = std::min(deadline, *registry_->restart_at);
    wait_for_events(processes, deadline);
    if (const int signal = signals_.take_stop()) stop_for(signal);
    for (SupervisedProcess* process : processes) process->forward_output();
    if (introspection_ && !all_ready_ && !exit_code_) look_for_readiness();
    for (const auto& member : members_) {
      if (const auto status = member->process.reap()) ended(*member, *status);
    }
    if (registry_->reap() && !exit_code_) {
      output_.error("the registry died; nodes that are connected go on; starting it again");
      registry_->restart_at = Clock::now() + options_.first_delay;
    }
    if (!exit_code_) restart_due();
    if (!exit_code_ && none_left()) all_ended();
  }

  void wait_for_events(const std::vector<SupervisedProcess*>& processes,
                       Clock::time_point deadline) const {
    std::vector<pollfd> files{{signals_.file(), POLLIN, 0}};
    for (SupervisedProcess* process : processes) {
      if (process->running()) files.push_back({process->child()->output(), POLLIN, 0});
    }
    const auto left = std::chrono::duration_cast<milliseconds>(deadline - Clock::now()).count() + 1;
    ::poll(files.data(), files.size(), static_cast<int>(std::max<long long>(0, left)));
    // A closed pipe polls as ready until its process is reaped; do not spin on it.
    const bool only_closed = std::all_of(files.begin(), files.end(), [](const pollfd& file) {
      return file.revents == 0 || file.revents == POLLHUP;
    });
    const bool some_closed = std::any_of(
        files.begin(), files.end(), [](const pollfd& file) { return file.revents == POLLHUP; });
    if (only_closed && some_closed) ::poll(files.data(), 1, 10);
  }

  void restart_due() {
    const auto now = Clock::now();
    if (registry_->restart_at && *registry_->restart_at <= now && !listen(endpoint_) &&
        !exit_code_) {
      output_.error("the registry cannot be started again; no node can join any more");
    }
    for (const auto& member : members_) {
      if (member->process.restart_at && *member->process.restart_at <= now) {
        member->process.start();
      }
    }
  }

  // What follows from a node's end while the launch is running or stopping.
  void ended(Member& member, int status) {
    SupervisedProcess& process = member.process;
    const std::string words = process.name() + ": " + describe_status(status);
    if (exit_code_) {
      if (!is_success(status)) output_.progress(words);
      return;
    }
    if (!is_success(status)) any_failed_ = true;
    const std::string last =
        process.last_line().empty() ? "" : "; it said last: " + process.last_line();
    if (member.node->required) {
      if (is_success(status)) {
        output_.success(process.name() + " finished");
        exit_code_ = 0;
      } else {
        output_.error("required node " + words + last);
        exit_code_ = 1;
      }
    } else if (member.node->respawn) {
      const bool was_steady = Clock::now() - process.started() >= options_.steady_time;
      process.delay = was_steady || process.delay.count() == 0
                          ? options_.first_delay
                          : std::min(options_.longest_delay, 2 * process.delay);
      process.restart_at = Clock::now() + process.delay;
      output_.warning(fmt::format("{}; starting it again in {:.1f} s", words,
                                  std::chrono::duration<double>(process.delay).count()));
    } else if (is_success(status)) {
      output_.progress(process.name() + " finished");
    } else if (!process.ready) {
      output_.error("node " + words + " before it was ready" + last);
      exit_code_ = 1;
    } else {
      output_.error("node " + words + last + "; the others go on without it");
    }
  }

  bool none_left() const {
    return std::none_of(members_.begin(), members_.end(), [](const auto& member) {
      return member->process.running() || member->process.restart_at;
    });
  }

  void all_ended() {
    output_.progress("all nodes have ended");
    exit_code_ = any_failed_ ? 1 : 0;
  }

  // --- readiness ---------------------------------------------------------------------------------

  void look_for_readiness() {
    std::vector<msgs::graph::NodeRecord> records;
    try {
      records = introspection_->nodes();
    } catch (const std::runtime_error&) {
      return;  // the registry is being restarted; its end is reported
    }
    std::size_t ready_count = 0;
    for (const auto& member : members_) {
      SupervisedProcess& process = member->process;
      for (const auto& record : records) {
        if (process.ready || !process.running() || record.pid() != process.child()->pid()) continue;
        process.ready = record.state() == msgs::graph::READY;
      }
      const bool finished = !process.running() && !process.restart_at;
      ready_count += process.ready || finished ? 1 : 0;
    }
    if (ready_count == members_.size()) {
      all_ready_ = true;
      output_.success(
          fmt::format("{} ready after {:.1f} s", nodes_text(), seconds_since(started_)));
      for (const auto& member : members_) check_remaps(*member->node, records);
    } else if (!late_named_ && Clock::now() - started_ > options_.ready_timeout) {
      late_named_ = true;
      for (const auto& member : members_) {
        if (!member->process.ready) output_.warning(member->node->name + " is still not ready");
      }
    }
  }

  // A remap whose new name the node does not use was of a name it does not know.
  void check_remaps(const LaunchNode& node, const std::vector<msgs::graph::NodeRecord>& records) {
    for (const auto& record : records) {
      if (record.name() != node.name) continue;
      std::vector<std::string> used;
      for (const auto& end : record.publishers()) used.push_back(end.topic());
      for (const auto& end : record.subscribers()) used.push_back(end.topic());
      for (const auto& offer : record.services()) used.push_back(offer.name());
      for (const auto& offer : record.actions()) used.push_back(offer.name());
      for (const auto& [from, to] : node.remaps) {
        if (std::find(used.begin(), used.end(), to) != used.end()) continue;
        output_.warning(node.place + ": remap of " + from + ": " + node.name +
                        " has no such topic, service or action" + nearest_match_hint(from, used));
      }
    }
  }

  // --- stopping ----------------------------------------------------------------------------------

  void stop_for(int signal) {
    if (exit_code_) {
      hurry_ = true;
      return;
    }
    output_.progress(std::string("SIG") + ::sigabbrev_np(signal) + ": stopping all nodes");
    exit_code_ = 0;
  }

  bool any_running() const {
    return std::any_of(members_.begin(), members_.end(),
                       [](const auto& member) { return member->process.running(); });
  }

  void signal_all(int signal) {
    for (const auto& member : members_) {
      if (member->process.running()) member->process.child()->send_signal(signal);
    }
  }

  void wait_until_ended(milliseconds time) {
    const auto deadline = Clock::now() + time;
    all_ready_ = true;  // nothing to wait for any more
    while (any_running() && !hurry_ && Clock::now() < deadline) {
      std::vector<SupervisedProcess*> processes{registry_.get()};
      for (const auto& member : members_) processes.push_back(&member->process);
      wait_for_events(processes, deadline);
      if (signals_.take_stop() != 0) hurry_ = true;
      for (SupervisedProcess* process : processes) process->forward_output();
      for (const auto& member : members_) {
        if (const auto status = member->process.reap()) ended(*member, *status);
      }
    }
  }

  void stop_all() {
    const auto start = Clock::now();
    signal_all(SIGINT);
    wait_until_ended(options_.interrupt_time);
    for (const auto& [signal, time] : {std::pair{SIGTERM, options_.terminate_time},
                                       std::pair{SIGKILL, options_.terminate_time}}) {
      if (!any_running()) break;
      if (hurry_ && signal == SIGTERM) continue;
      for (const auto& member : members_) {
        if (!member->process.running()) continue;
        output_.warning(member->node->name + " does not stop: sending SIG" +
                        ::sigabbrev_np(signal));
      }
      hurry_ = false;
      signal_all(signal);
      wait_until_ended(time);
    }
    if (registry_ && registry_->running()) {
      registry_->child()->send_signal(SIGTERM);
      const auto deadline = Clock::now() + kRegistryStop;
      while (registry_->running() && Clock::now() < deadline) {
        wait_for_events({registry_.get()}, deadline);
        registry_->forward_output();
        registry_->reap();
        signals_.take_stop();
      }
    }
    if (members_.empty()) return;
    std::string memory;
    for (const auto& member : members_) {
      memory += fmt::format("{}{} {:.0f}", memory.empty() ? "" : ", ", member->node->name,
                            static_cast<double>(member->process.peak_memory()) * 1e-6);
    }
    output_.progress("peak memory [MB]: " + memory);
    output_.progress(fmt::format("all stopped after {:.1f} s", seconds_since(start)));
  }

  const LaunchGraph& graph_;
  const SupervisorOptions options_;
  SignalSource signals_;  // first: threads made later inherit the blocked signals
  LaunchOutput output_;
  std::unique_ptr<SupervisedProcess> registry_;
  std::string endpoint_;
  std::vector<std::unique_ptr<Member>> members_;
  std::unique_ptr<Introspection> introspection_;
  Clock::time_point started_{};
  std::optional<int> exit_code_;  // set once the launch is to end
  bool all_ready_ = false, late_named_ = false, any_failed_ = false, hurry_ = false;
};

}  // namespace

int run_launch(const LaunchGraph& graph, const SupervisorOptions& options) {
  return Supervisor(graph, options).run();
}

}  // namespace prehend::graph::launch
