#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "bench/graph/job.h"

namespace prehend::bench {

/// A child process. It is told to end when this one dies, and killed if still alive when this
/// object goes.
class WorkerProcess {
 public:
  /// Runs `program` with `arguments`; its stdout is a pipe. `channel_end` (when >= 0) becomes its
  /// descriptor kChannelDescriptor. Throws BenchError when it cannot start.
  WorkerProcess(const std::string& program, const std::vector<std::string>& arguments,
                int channel_end);
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  static constexpr int kChannelDescriptor = 3;

  int pid() const { return pid_; }
  int output() const { return output_; }
  /// Reads what is there; false at the end of the output.
  bool read_output();
  const std::string& text() const { return text_; }
  /// Reaps it, killing it first when it lives at `deadline` [monotonic_now]. Whether it ended well.
  bool finish(std::int64_t deadline);
  double cpu_seconds() const { return cpu_seconds_; }

 private:
  int pid_ = -1;
  int output_ = -1;
  std::string text_;
  double cpu_seconds_ = 0.0;
};

/// What the workers of one job wrote: `key value value ...` a line.
struct WorkerOutput {
  bool ok = false;
  std::vector<std::int64_t> latencies;    ///< ns
  std::map<std::string, double> figures;  ///< sent, received, seconds, ...
  double cpu_seconds = 0.0;               ///< of both, user and system, with start and end
};

/// Adds what a worker wrote to its stdout; lines of another form are left out.
void parse_output(const std::string& text, WorkerOutput& output);

/// Runs a job in fresh processes of `program`, so that no row's heap is another's: sender and
/// receiver, or one with both. Takes at most job.seconds + 40 s.
WorkerOutput run_workers(const std::string& program, const Job& job, bool same_process);

/// The command line of a worker, and back. The first argument is "--worker".
std::vector<std::string> worker_arguments(const std::string& role, const Job& job);
struct WorkerCommand {
  std::string role;  ///< sender, receiver or both
  Job job;
};
/// Throws BenchError when `argv` is not what worker_arguments makes.
WorkerCommand parse_worker_arguments(int argc, char** argv);

}  // namespace prehend::bench
