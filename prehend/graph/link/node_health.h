#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>

#include "prehend/graph/node.h"

namespace prehend::graph {

/// What a node is worth at the moment: its own word, unless something speaks against it. A failed
/// callback does for a while, so that one damaged request does not count for ever; what another
/// node does wrong, until that one is gone. Not thread-safe.
class NodeHealth {
 public:
  using Time = std::chrono::steady_clock::time_point;
  struct Word {
    Health level = Health::kOk;
    std::string text;
    bool operator==(const Word&) const = default;
  };

  static constexpr std::chrono::seconds kFailureCounts{5};

  /// The node's own word; false when it said that already.
  bool say(const Word& own);
  /// A callback, or a part of one, failed; false when that is what was said last.
  bool fail(const Word& failure, Time now);
  /// `about` (a node's instance) does something wrong, until release(about).
  void hold(const std::string& about, const std::string& text);
  void release(const std::string& about) { held_.erase(about); }
  /// The word to publish, if it is not the one that was.
  bool take_news(Time now, Word& word);

  const Word& told() const { return told_; }
  /// Callbacks that have failed, in all.
  std::uint64_t failures() const { return failures_; }

 private:
  Word own_, told_;
  std::map<std::string, std::string> held_;  // about -> text
  Word failure_;                             // ok: none that counts
  Time failed_{};
  std::uint64_t failures_ = 0;
};

}  // namespace prehend::graph
