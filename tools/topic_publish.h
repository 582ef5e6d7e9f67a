#pragma once

#include <cstdint>
#include <string>

namespace prehend::tools {

struct PublishOptions {
  std::string registry, topic, type, text;
  double rate = 0;          ///< messages a second, 0: one message
  std::uint64_t count = 0;  ///< messages at `rate`, 0: until interrupted
  double wait = 3;          ///< for a subscriber [s]
  bool latched = false;     ///< the last message is kept for late subscribers
  double hold = 0;          ///< how long one latched message stays there [s], 0: until interrupted
};

/// Publishes a message given as protobuf text or JSON, as a node of the graph. Returns an exit
/// code. Throws std::runtime_error when the registry does not answer, the type is unknown or the
/// message is none of it.
int publish_topic(const PublishOptions& options);

}  // namespace prehend::tools
