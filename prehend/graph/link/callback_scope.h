#pragma once

#include <string>

#include "prehend/graph/clock.h"

namespace prehend::graph {

/// Marks this thread as being in a callback of a node, which is known by its clock. Scopes nest:
/// with several nodes in a process one's callback may run another's in a wait.
class CallbackScope {
 public:
  /// `source`: what calls back, e.g. "subscription of /objects".
  CallbackScope(const Clock::State& node, const std::string& source);
  ~CallbackScope();
  CallbackScope(const CallbackScope&) = delete;
  CallbackScope& operator=(const CallbackScope&) = delete;

  /// The callback of that node in which this thread is; null: in none.
  static const std::string* source_of(const Clock::State& node);

 private:
  const Clock::State& node_;
  const std::string& source_;
  const CallbackScope* const outer_;
};

/// Why something that blocks must not be done by this thread now: one line with `what` (the call),
/// the callback it is in, and `instead`. Empty when this thread is in no callback of that node.
std::string refuse_blocking(const Clock::State& node, const std::string& what,
                            const std::string& instead);

}  // namespace prehend::graph
