#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/graph/rows.h"
#include "bench/graph/worker_pair.h"

namespace prehend::bench {

/// Nearest-rank percentile, `fraction` in (0, 1]. Not for an empty vector.
double percentile(std::vector<double> values, double fraction);

/// What was measured of one row, over all rounds.
class RowResult {
 public:
  explicit RowResult(const Row& row) : row_(row) {}
  /// Adds one round.
  void add(const WorkerOutput& output);

  const Row& row() const { return row_; }
  /// Nothing is known of a row of which a round failed.
  bool ok() const { return !failed_ && messages_ > 0; }
  std::uint64_t messages() const { return messages_; }
  /// Latency [µs]; not for throughput rows.
  double p50() const { return percentile(latencies_, 0.5); }
  double p90() const { return percentile(latencies_, 0.9); }
  double p99() const { return percentile(latencies_, 0.99); }
  /// Least median of a round [µs]: what the machine does when nothing else runs.
  double best_p50() const { return best_p50_; }
  /// CPU time of both processes per message [µs], their start and end included.
  double cpu_per_message() const;
  /// Of throughput rows: messages per second that reached the callback, in the best round.
  double rate() const { return rate_; }
  std::uint64_t lost() const { return lost_; }

 private:
  Row row_;
  bool failed_ = false;
  std::vector<double> latencies_;  // µs
  std::uint64_t messages_ = 0;
  std::uint64_t lost_ = 0;
  double best_p50_ = 0.0;
  double cpu_seconds_ = 0.0;
  double rate_ = 0.0;
};

/// A promise about the figures.
struct Target {
  std::string name;
  double value = 0.0;
  double limit = 0.0;
  bool at_least = false;  ///< else at most
  std::string unit{};     ///< empty: a ratio
  bool aim = false;       ///< wished for, not promised
  bool met() const { return at_least ? value >= limit : value <= limit; }
};

/// The promises of which all rows were measured.
std::vector<Target> targets(const std::vector<RowResult>& results);

}  // namespace prehend::bench
