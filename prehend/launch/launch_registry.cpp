#include "prehend/launch/launch_registry.h"

#include <fmt/core.h>
#include <signal.h>

#include <stdexcept>

#include "prehend/graph/introspection.h"
#include "prehend/graph/node.h"

namespace prehend::launch {
namespace {

using Clock = SupervisedProcess::Clock;
using std::chrono::milliseconds;

constexpr milliseconds kStartTime{5000};
constexpr milliseconds kStopTime{3000};
constexpr milliseconds kRestartDelay{500};
constexpr milliseconds kQuestionTime{300};
constexpr const char* kListens = "listens on ";

}  // namespace

int LaunchRegistry::start() {
  if (options_.join_registry) return join(options_.registry);
  const bool free_choice = options_.registry.empty();
  if (const int signal =
          listen(free_choice ? graph::kDefaultRegistryEndpoint : options_.registry)) {
    return signal;
  }
  if (!endpoint_.empty()) return 0;
  if (free_choice) {
    output_.progress("taking a free port for the registry instead");
    if (const int signal = listen("tcp://127.0.0.1:*")) return signal;
    if (!endpoint_.empty()) {
      output_.progress("to look at this graph, not the one there: export PREHEND_REGISTRY=" +
                       endpoint_);
    }
  }
  if (endpoint_.empty()) {
    throw std::runtime_error("the registry did not start" +
                             (free_choice ? std::string() : " at " + options_.registry) +
                             "; its words are above");
  }
  return 0;
}

// Starts the process and sets endpoint_ once it listens.
int LaunchRegistry::listen(const std::string& endpoint) {
  process_ = std::make_unique<SupervisedProcess>(
      "registry", std::vector<std::string>{options_.registry_program, "--registry", endpoint},
      std::map<std::string, std::string>{}, ProcessorShare{}, output_);
  process_->start();
  const auto deadline = Clock::now() + kStartTime;
  while (process_->running() && Clock::now() < deadline) {
    wait_for_events(signals_, {process_.get()}, deadline);
    process_->forward_output();
    const std::string& line = process_->last_line();
    if (const auto at = line.find(kListens); at != std::string::npos) {
      endpoint_ = line.substr(at + std::string(kListens).size());
      return 0;
    }
    process_->reap();
    if (const int signal = signals_.take_stop()) return signal;
  }
  return 0;
}

int LaunchRegistry::join(const std::string& endpoint) {
  graph::Introspection introspection(endpoint, kQuestionTime);
  const auto start = Clock::now();
  output_.progress("joining the registry at " + endpoint);
  while (Clock::now() - start < options_.registry_timeout) {
    try {
      introspection.nodes();
      endpoint_ = endpoint;
      return 0;
    } catch (const graph::KeyError&) {
      throw;  // waiting does not mend it
    } catch (const std::runtime_error&) {
      // not yet there
    }
    wait_for_events(signals_, {}, Clock::now() + kQuestionTime);
    if (const int signal = signals_.take_stop()) return signal;
  }
  throw std::runtime_error(fmt::format(
      "no registry answers at {} within {:.0f} s; launch the file on its registry_host first",
      endpoint, std::chrono::duration<double>(options_.registry_timeout).count()));
}

int LaunchRegistry::keep_alive() {
  if (!process_) return 0;
  if (process_->reap()) {
    output_.error("the registry died; nodes that are connected go on; starting it again");
    process_->restart_at = Clock::now() + kRestartDelay;
  }
  if (!process_->restart_at || *process_->restart_at > Clock::now()) return 0;
  const std::string endpoint = std::exchange(endpoint_, "");
  const int signal = listen(endpoint);
  if (endpoint_.empty()) {
    endpoint_ = endpoint;
    if (signal == 0) {
      output_.error("the registry cannot be started again; no node can join any more");
    }
  }
  return signal;
}

bool LaunchRegistry::stop() {
  if (!process_ || !process_->running()) return true;
  process_->child()->send_signal(SIGTERM);
  const auto deadline = Clock::now() + kStopTime;
  while (process_->running() && Clock::now() < deadline) {
    wait_for_events(signals_, {process_.get()}, deadline);
    process_->forward_output();
    process_->reap();
    signals_.take_stop();
  }
  return !process_->running();
}

}  // namespace prehend::launch
