#include "bench/graph/results.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace prehend::bench {
namespace {

using Figure = std::optional<double>;

class Figures {
 public:
  explicit Figures(const std::vector<RowResult>& results) : results_(results) {}

  const RowResult* find(const std::string& name) const {
    for (const RowResult& result : results_) {
      if (result.ok() && result.row().name() == name) return &result;
    }
    return nullptr;
  }
  Figure ratio(const std::string& a, const std::string& b) const {
    const RowResult* first = find(a);
    const RowResult* second = find(b);
    if (!first || !second) return std::nullopt;
    return first->p50() / second->p50();
  }
  /// The largest p50 of a peer's rows.
  Figure worst(const std::string& peer) const {
    Figure value;
    for (const RowResult& result : results_) {
      if (!result.ok() || result.row().kind->name != peer) continue;
      value = std::max(value.value_or(0.0), result.p50());
    }
    return value;
  }

 private:
  const std::vector<RowResult>& results_;
};

}  // namespace

double percentile(std::vector<double> values, double fraction) {
  const auto rank =
      static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(values.size())));
  const auto position =
      values.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(rank, 1)) - 1;
  std::nth_element(values.begin(), position, values.end());
  return *position;
}

void RowResult::add(const WorkerOutput& output) {
  const auto figure = [&](const std::string& key) {
    const auto found = output.figures.find(key);
    return found == output.figures.end() ? 0.0 : found->second;
  };
  const bool measured = row_.kind->throughput ? figure("received") > 0 : !output.latencies.empty();
  failed_ = failed_ || !output.ok || !measured;
  if (failed_) return;
  cpu_seconds_ += output.cpu_seconds;
  if (row_.kind->throughput) {
    messages_ += static_cast<std::uint64_t>(figure("received"));
    lost_ += static_cast<std::uint64_t>(figure("sent") - figure("received"));
    rate_ = std::max(rate_, figure("received") / figure("seconds"));
    return;
  }
  std::vector<double> round;
  for (const std::int64_t value : output.latencies)
    round.push_back(static_cast<double>(value) * 1e-3);
  const double median = percentile(round, 0.5);
  best_p50_ = messages_ == 0 ? median : std::min(best_p50_, median);
  messages_ += round.size();
  latencies_.insert(latencies_.end(), round.begin(), round.end());
}

double RowResult::cpu_per_message() const {
  return cpu_seconds_ * 1e6 / static_cast<double>(messages_);
}

std::vector<Target> targets(const std::vector<RowResult>& results) {
  const Figures figures(results);
  std::vector<Target> all;
  const auto add = [&](Target target, Figure value) {
    if (!value) return;
    target.value = *value;
    all.push_back(target);
  };
  add({.name = "slab_copy/4MB : inline/4MB", .limit = 0.5},
      figures.ratio("slab_copy/4MB", "inline/4MB"));
  add({.name = "slab_copy/4MB : ring/4MB", .limit = 1.5},
      figures.ratio("slab_copy/4MB", "ring/4MB"));
  add({.name = "inline/4MB : naive_warm/4MB", .limit = 0.7},
      figures.ratio("inline/4MB", "naive_warm/4MB"));
  add({.name = "slab_copy/640KB : ros1/640KB", .limit = 0.5},
      figures.ratio("slab_copy/640KB", "ros1/640KB"));
  add({.name = "slab_copy/4MB : ros1/4MB", .limit = 0.5},
      figures.ratio("slab_copy/4MB", "ros1/4MB"));
  add({.name = "slab_loaned, slowest size", .limit = 100.0, .unit = "us"},
      figures.worst("slab_loaned"));
  add({.name = "same_process, slowest size", .limit = 5.0, .unit = "us"},
      figures.worst("same_process"));
  if (const RowResult* row = figures.find("throughput_publish_all/100B")) {
    add({.name = "throughput_publish_all/100B", .limit = 1e6, .at_least = true, .unit = "msg/s"},
        row->rate());
  }
  if (const RowResult* row = figures.find("inline/100B")) {
    add({.name = "inline/100B", .limit = 10.0, .unit = "us", .aim = true}, row->p50());
  }
  return all;
}

}  // namespace prehend::bench
