#pragma once

#include <cstdint>
#include <string>

namespace prehend::tools {

struct EchoOptions {
  std::string registry, topic;
  std::uint64_t count = 0;  ///< 0: until interrupted; of what is latched the newest
  bool full = false;        ///< long byte fields in full
  bool wait = false;        ///< for a topic nobody publishes yet
  bool json = false;  ///< one object a line; unless `full`, lists beyond 1000 elements and bytes
                      ///< beyond 64 KiB are cut, and a member "shortened" has their sizes
};

/// Prints a topic's messages as a node of the graph. Returns an exit code. Throws
/// std::runtime_error when the registry does not answer or the topic is unknown.
int echo_topic(const EchoOptions& options);

}  // namespace prehend::tools
