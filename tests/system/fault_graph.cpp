#include "tests/system/fault_graph.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>

namespace prehend::testing {
namespace {

int free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  const bool bound =
      ::bind(socket, generic, size) == 0 && ::getsockname(socket, generic, &size) == 0;
  ::close(socket);
  if (!bound) throw std::runtime_error("no free port on loopback");
  return ntohs(address.sin_port);
}

}  // namespace

FaultGraph::FaultGraph() : endpoint_("tcp://127.0.0.1:" + std::to_string(free_port())) {
  std::filesystem::create_directory(runtime_base());
  ::setenv("XDG_RUNTIME_DIR", runtime_base().c_str(), 1);
  ::setenv("PREHEND_REGISTRY", endpoint_.c_str(), 1);
}

FaultGraph::~FaultGraph() {
  for (const auto& [name, process] : processes_) ::kill(process.process->pid(), SIGKILL);
}

void FaultGraph::launch(const std::string& name, const std::string& program,
                        std::vector<std::string> arguments) {
  const auto output = folder() / (name + "-" + std::to_string(++starts_) + ".txt");
  processes_[name].process = std::make_unique<Launched>(program, std::move(arguments), output);
}

void FaultGraph::start_registry() {
  processes_["registry"].start = [this] { launch("registry", "registry", {}); };
  restart("registry");
}

void FaultGraph::start_publisher(const std::string& name, int index) {
  const std::string state = folder() / (name + ".state");
  Process& process = processes_[name];
  process.state = std::make_unique<TrafficFile>(state);
  process.index = index;
  process.start = [=, this] {
    launch(name, "traffic_node",
           {"publish", "--name", name, "--param", "state:=" + state, "--param",
            "index:=" + std::to_string(index)});
  };
  restart(name);
}

void FaultGraph::start_subscriber(const std::string& name) {
  const std::string state = folder() / (name + ".state");
  Process& process = processes_[name];
  process.state = std::make_unique<TrafficFile>(state);
  process.listens = true;
  process.start = [=, this] {
    launch(name, "traffic_node", {"subscribe", "--name", name, "--param", "state:=" + state});
  };
  restart(name);
}

void FaultGraph::start_recorder(const std::string& name) {
  processes_[name].start = [this, name] {
    const std::string file = folder() / ("recording-" + std::to_string(starts_) + ".mcap");
    processes_[name].recording = file;
    launch(name, "recorder", {"--name", name, "--param", "output:=" + file});
  };
  restart(name);
}

std::vector<std::string> FaultGraph::names() const {
  std::vector<std::string> names;
  for (const auto& [name, process] : processes_) names.push_back(name);
  return names;
}

std::vector<std::string> FaultGraph::publishers() const {
  std::vector<std::string> names;
  for (const auto& [name, process] : processes_) {
    if (process.index >= 0) names.push_back(name);
  }
  return names;
}

std::vector<std::string> FaultGraph::subscribers() const {
  std::vector<std::string> names;
  for (const auto& [name, process] : processes_) {
    if (process.listens) names.push_back(name);
  }
  return names;
}

void FaultGraph::send_signal(const std::string& name, int signal) {
  processes_.at(name).process->send_signal(signal);
}

void FaultGraph::kill(const std::string& name) {
  send_signal(name, SIGKILL);
  if (!processes_.at(name).process->wait(std::chrono::seconds(10))) {
    throw std::runtime_error(name + " does not die");
  }
}

void FaultGraph::restart(const std::string& name) {
  Process& process = processes_.at(name);
  process.process.reset();
  if (process.state) process.state->clear();
  process.start();
}

std::optional<int> FaultGraph::stop(const std::string& name) {
  send_signal(name, SIGINT);
  return processes_.at(name).process->wait(std::chrono::seconds(10));
}

}  // namespace prehend::testing
