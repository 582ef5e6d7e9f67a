#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

namespace prehend::launch {

/// Processes of a launch that did not end well, for its last lines: what was said when it happened
/// has long scrolled away by then.
class Deaths {
 public:
  using Seconds = std::chrono::duration<double>;

  /// `how`: "exit code 3", "signal SIGKILL", "killed, as it did not stop". `when`: since the
  /// launch's start.
  void add(const std::string& process, const std::string& how, Seconds when);
  /// It was started again, and lived to the end.
  void forgive(const std::string& process);

  /// One that was not forgiven.
  bool any_for_good() const;
  /// One line for each process: how often it died, of what last, and whether for good.
  struct Line {
    std::string text;
    bool for_good;
  };
  std::vector<Line> lines() const;

 private:
  struct Entry {
    int count = 0;
    std::string last;
    Seconds when{0};
    bool for_good = true;
  };
  std::map<std::string, Entry> entries_;
};

}  // namespace prehend::launch
