#pragma once

#include <cstdint>
#include <string>

namespace prehend::tools {

struct MeasureOptions {
  enum class Quantity { kRate, kBandwidth, kDelay };
  Quantity quantity = Quantity::kRate;
  std::string registry, topic;
  std::string clock = "auto";   ///< of delays: wall, simulated, or auto: what the graph uses
  double duration = 0;          ///< [s], 0: until interrupted
  std::uint64_t count = 0;      ///< messages, 0: until interrupted
  std::uint64_t window = 1000;  ///< latest messages the figures are of
  bool json = false;            ///< one object a line
};

/// Measures a topic as a node of the graph and prints a line each second and at the end. Returns an
/// exit code. Throws std::runtime_error when the registry does not answer or nobody publishes the
/// topic.
int measure_topic(const MeasureOptions& options);

}  // namespace prehend::tools
