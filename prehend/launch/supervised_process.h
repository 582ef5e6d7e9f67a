#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "prehend/launch/child_process.h"
#include "prehend/launch/launch_output.h"

namespace prehend::launch {

/// One program of a launch over all its restarts: splits its output into lines for a LaunchOutput.
class SupervisedProcess {
 public:
  using Clock = std::chrono::steady_clock;

  SupervisedProcess(std::string name, std::vector<std::string> command,
                    std::map<std::string, std::string> environment, ProcessorShare share,
                    LaunchOutput& output)
      : name_(std::move(name)),
        command_(std::move(command)),
        environment_(std::move(environment)),
        share_(std::move(share)),
        output_(output) {}

  void start();
  /// Shows what the child has written; false when there was nothing.
  bool forward_output();
  /// The status when the child has just ended: once for each start. All its output is out by then.
  std::optional<int> reap();

  const std::string& name() const { return name_; }
  bool running() const { return child_ != nullptr; }
  /// It runs, will run again, or has not run yet.
  bool is_wanted() const { return running() || restart_at || !was_started(); }
  bool was_started() const { return started_ != Clock::time_point{}; }
  ChildProcess* child() { return child_.get(); }
  /// The last line it wrote that is not blank.
  const std::string& last_line() const { return last_line_; }
  Clock::time_point started() const { return started_; }
  /// Largest resident memory over all ended runs [bytes].
  std::int64_t peak_memory() const { return peak_memory_; }

  bool ready = false;                           ///< the registry has it as ready, since its start
  bool was_ready = false;                       ///< in any of its runs
  std::optional<Clock::time_point> restart_at;  ///< when to start it again
  std::chrono::duration<double> delay{0};       ///< of the last restart
  bool succeeded = false;                       ///< its last run ended with exit code 0
  int failed_starts = 0;                        ///< runs in a row that failed before it was ready

 private:
  void show_line(std::string_view line);

  const std::string name_;
  const std::vector<std::string> command_;
  const std::map<std::string, std::string> environment_;
  const ProcessorShare share_;
  LaunchOutput& output_;
  std::unique_ptr<ChildProcess> child_;
  std::string partial_line_, last_line_;
  Clock::time_point started_{};
  std::int64_t peak_memory_ = 0;
};

}  // namespace prehend::launch
