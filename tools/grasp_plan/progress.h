#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdio>
#include <mutex>
#include <string>
#include <thread>

namespace prehend::tools {

/// Says what a command is at, once that takes long: a line for each stage that lasts, none for
/// those that are over before anyone wonders.
class Progress {
 public:
  /// `patience` is how long a stage may last in silence; 0: no stage is silent. @pre `stream` stays
  /// open.
  explicit Progress(std::chrono::milliseconds patience = std::chrono::milliseconds(500),
                    std::FILE* stream = stderr);
  /// Ends the last stage.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Ends the stage before and begins one, as "reading object.ply".
  void stage(const std::string& what);
  /// Ends the stage: from now on nothing lasts.
  void over();

 private:
  void watch();

  const std::chrono::milliseconds patience_;
  std::FILE* const stream_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string silent_;  // the stage that nobody has been told of; empty: none
  std::chrono::steady_clock::time_point told_at_;  // when it is told
  bool ended_ = false;
  std::thread watcher_;
};

/// As "2,000,000".
std::string with_commas(std::size_t number);

}  // namespace prehend::tools
