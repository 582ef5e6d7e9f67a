#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

namespace prehend::sweep {

/// A case that is to run, and what it took before.
struct OpenCase {
  std::int64_t index = 0;
  std::optional<double> seconds;
};

/// Says which case runs next: those of unknown length first, as they may be the longest, then by
/// length, longest first (R. L. Graham, "Bounds on multiprocessing timing anomalies", 1969: within
/// 4/3 of the best end), equal ones in their order. Cases whose worker was lost come again at once.
class Handout {
 public:
  /// How often a case is given to a worker before it counts as failed.
  static constexpr int kAttempts = 3;

  explicit Handout(std::vector<OpenCase> open);

  /// Nothing when none is left; one that is lost may come back later.
  std::optional<std::int64_t> next();
  /// The worker of `index` was lost: true when it will come again, false when that was its last
  /// attempt.
  bool lost(std::int64_t index);

  std::int64_t total() const { return static_cast<std::int64_t>(open_.size()); }

 private:
  std::vector<OpenCase> open_;
  std::size_t next_ = 0;
  std::deque<std::int64_t> again_;
  std::map<std::int64_t, int> lost_;
};

}  // namespace prehend::sweep
