#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/callback_scope.h"
#include "prehend/graph/link/clock_state.h"
#include "prehend/graph/link/executor.h"
#include "prehend/graph/link/io_loop.h"
#include "prehend/graph/link/slab.h"
#include "prehend/graph/node.h"

namespace prehend::graph {

/// What a node uses each topic, service and action name for, once each. Thread-safe.
class UsedNames {
 public:
  /// False when that purpose has the name already.
  bool take(const std::string& purpose, const std::string& name) {
    const std::lock_guard lock(mutex_);
    return names_.insert({purpose, name}).second;
  }
  void release(const std::string& purpose, const std::string& name) {
    const std::lock_guard lock(mutex_);
    names_.erase({purpose, name});
  }

 private:
  std::mutex mutex_;
  std::set<std::pair<std::string, std::string>> names_;
};

/// What the parts of a node share, and its handles keep alive beyond the node itself: they find
/// the loop closed and the executor stopped then.
struct NodeLink {
  std::string node_name;
  std::string instance;
  bool use_pointers = true;         ///< between nodes of this process
  bool use_slab = true;             ///< between processes of this host
  std::shared_ptr<SlabPool> slabs;  ///< null unless use_slab
  UsedNames names;
  std::shared_ptr<Clock::State> clock;
  std::shared_ptr<IoLoop> loop;
  std::shared_ptr<Executor> executor;
  /// May be called from any thread while the node lives.
  std::function<void(LogLevel, const std::string&)> log;
  std::function<void(const std::string& source, const std::string& what)> callback_failed;
  /// What a node (its instance) does wrong: an error of this one's health until that one is gone.
  std::function<void(const std::string& instance, const std::string& text)> hold_against;
  /// Sends to a client, in the order of the calls. May be called from any thread.
  std::function<void(const std::string& client, const msgs::graph::PeerMessage&)> send_to_client;
  /// Messages given to send_to_client that the loop has not come to yet.
  std::atomic<std::size_t> waiting_to_send{0};
  /// In the loop's thread: what the node publishes, subscribes or offers has changed.
  std::function<void()> record_changed;
};

/// When `timeout` from now is over; a year at most, so that "for ever" does not overflow.
inline std::chrono::steady_clock::time_point deadline_after(std::chrono::nanoseconds timeout) {
  return std::chrono::steady_clock::now() +
         std::min<std::chrono::nanoseconds>(timeout, std::chrono::hours(24 * 365));
}

/// A count that is worth one visible line, at most one a second.
class LossLine {
 public:
  /// True when `total` has grown since the last line and that one is a second ago, or `now_at_any
  /// rate`: the caller then logs.
  bool is_due(std::uint64_t total, bool at_any_rate = false) {
    const auto now = std::chrono::steady_clock::now();
    if (total <= logged_ || (!at_any_rate && now - last_ < std::chrono::seconds(1))) return false;
    logged_ = total;
    last_ = now;
    return true;
  }

 private:
  std::uint64_t logged_ = 0;
  std::chrono::steady_clock::time_point last_ =
      std::chrono::steady_clock::now() - std::chrono::hours(1);
};

}  // namespace prehend::graph
