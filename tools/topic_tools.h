#pragma once

#include <cstdint>
#include <string>

namespace prehend::tools {

// Commands that join the graph as a node for as long as they run, and return an exit code. Each
// throws std::runtime_error when the registry does not answer or the topic is unknown.

struct EchoOptions {
  std::string registry, topic;
  std::uint64_t count = 0;  ///< 0: until interrupted
  bool full = false;        ///< long byte fields in full
  bool wait = false;        ///< for a topic nobody publishes yet
};
int echo_topic(const EchoOptions& options);

struct RateOptions {
  std::string registry, topic;
  double duration = 0;  ///< [s], 0: until interrupted
};
int measure_topic(const RateOptions& options);

struct PublishOptions {
  std::string registry, topic, type, text;
  double rate = 0;  ///< messages a second, 0: one message
  double wait = 3;  ///< for a subscriber [s]
};
int publish_topic(const PublishOptions& options);

}  // namespace prehend::tools
