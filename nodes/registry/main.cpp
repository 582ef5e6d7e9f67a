// The registry: introduces the nodes of a graph to each other. See prehend/graph/registry.h.

#include <fmt/core.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "prehend/text/command_line.h"

int main(int argc, char** argv) {
  prehend::graph::RegistryOptions options;
  const char* from_environment = std::getenv("PREHEND_REGISTRY");
  options.endpoint = from_environment && *from_environment
                         ? from_environment
                         : prehend::graph::kDefaultRegistryEndpoint;
  CLI::App app(
      "The registry of a graph: which nodes live, what they publish, subscribe and serve. Nodes "
      "find "
      "each other through it; messages do not pass through it. Prints the endpoint it listens on.");
  app.add_option("--endpoint,--registry", options.endpoint,
                 "Where to listen; tcp://127.0.0.1:* takes a free port; default: PREHEND_REGISTRY")
      ->capture_default_str();
  app.add_option("--keys", options.keys_file,
                 "Key file of the graph, see prehend keys; default: PREHEND_KEYS, else none");
  if (const auto code = prehend::text::parse_command_line(app, argc, argv)) return *code;

  sigset_t signals;  // blocked before threads are made, so that this one alone waits for them
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  try {
    const prehend::graph::Registry registry(options);
    fmt::print("registry listens on {}\n", registry.endpoint());
    std::fflush(stdout);
    int signal = 0;
    sigwait(&signals, &signal);
  } catch (const std::exception& error) {
    fmt::print(stderr, "registry: {}\n", error.what());
    return 1;
  }
  return 0;
}
