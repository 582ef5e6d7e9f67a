#pragma once

#include <cstddef>

namespace prehend::graph {

/// How many messages wait where a reader is slower than a writer, and what a late reader gets.
///
/// | policy     | a publisher                                | a subscriber                        |
/// |------------|--------------------------------------------|-------------------------------------|
/// | latest     | only the newest waits for a slow reader    | only the newest waits for callback  |
/// | queue(n)   | n wait for each slow reader                | n wait for the callback             |
/// | latched(n) | as queue(n); the last n go to late readers | as queue(n); warns if not latched   |
///
/// A full queue drops its oldest message. Drops of queue and latched are counted and logged; what
/// `latest` overwrites is counted only, as that is what was asked for. Every subscriber to a latched
/// publisher gets its history on joining, at most as many messages as its own queue holds.
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
