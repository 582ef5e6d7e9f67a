#pragma once

#include <chrono>
#include <cstdlib>
#include <string>

#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"

namespace prehend::bench {

/// Carries --busy-wait [s] to the worker processes.
inline constexpr const char* kBusyWaitVariable = "PREHEND_BENCH_BUSY_WAIT";

/// A quiet node of a benchmark's own graph.
inline graph::NodeOptions node_options(const std::string& name, const std::string& registry,
                                       bool use_slab = true) {
  graph::NodeOptions options;
  options.name = name;
  options.registry = registry;
  options.log_level = graph::LogLevel::kError;
  options.use_slab = use_slab;
  if (const char* seconds = std::getenv(kBusyWaitVariable)) {
    options.busy_wait = std::chrono::nanoseconds(static_cast<std::int64_t>(atof(seconds) * 1e9));
  }
  return options;
}

}  // namespace prehend::bench
