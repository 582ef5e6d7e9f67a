#pragma once

#include <string>
#include <vector>

namespace prehend::control {

/// How the attempts of a cycle failed.
class FailedAttempts {
 public:
  void clear() { attempts_.clear(); }
  /// The next attempt failed for `reason` when it had come as far as `progress` (its step).
  void add(int progress, const std::string& reason) { attempts_.push_back({progress, reason}); }

  /// "no grasp succeeded in 3 attempts; attempt 1 came furthest: lost while carrying: ...; the
  /// last: closed completely, ...". What came last is often what an earlier failure led to: an
  /// object that was lost lies elsewhere, and the next attempt closes on nothing. "no grasp was
  /// tried", as after a probe, when nothing was added.
  std::string text() const;

 private:
  struct Attempt {
    int progress = 0;
    std::string reason;
  };
  std::vector<Attempt> attempts_;
};

}  // namespace prehend::control
