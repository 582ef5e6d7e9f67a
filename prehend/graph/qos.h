#pragma once

#include <cstddef>

namespace prehend::graph {

/// How many messages wait where a reader is slower than a writer, and what a late reader gets.
///
/// - latest: a publisher keeps only the newest for a slow reader, a subscriber only the newest for
///   its callback.
/// - queue(n): n messages wait for each slow reader, or for the callback.
/// - latched(n): as queue(n); besides, a publisher's last n messages go to late readers. A
///   subscriber that asks for it is warned when the publisher keeps none.
///
/// A full queue drops its oldest message. Drops of queue and latched are counted and logged; what
/// `latest` overwrites is counted only, as that is what was asked for. Every subscriber to a
/// latched publisher gets its history on joining, at most as many messages as its own queue holds.
struct QoS {
  enum class Policy { kLatest, kQueue, kLatched };

  /// Bound of every queue in bytes, unless told otherwise.
  static constexpr std::size_t kDefaultMaxBytes = std::size_t{256} << 20;

  Policy policy = Policy::kQueue;
  std::size_t depth = 10;                    ///< messages, > 0
  std::size_t max_bytes = kDefaultMaxBytes;  ///< of the messages that wait; one message may exceed

  static QoS latest() { return {Policy::kLatest, 1, kDefaultMaxBytes}; }
  static QoS queue(std::size_t depth, std::size_t max_bytes = kDefaultMaxBytes) {
    return {Policy::kQueue, depth, max_bytes};
  }
  static QoS latched(std::size_t depth = 1, std::size_t max_bytes = kDefaultMaxBytes) {
    return {Policy::kLatched, depth, max_bytes};
  }
};

}  // namespace prehend::graph
