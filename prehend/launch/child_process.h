#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace prehend::launch {

/// Where and when a process runs.
struct ProcessorShare {
  std::vector<int> cpus;  ///< those it may run on; empty: all
  int nice = 0;           ///< >= 0: added to its parent's nice value, 19 at most in all
};

/// A program running as a child process, in a session of its own, with both output streams in one
/// pipe and no input. The kernel kills it when the thread that started it ends, so that it never
/// outlives its parent, however that ends.
///
/// A session of its own, since Linux shares out processors among sessions first (sched(7),
/// autogroup). In one session with others, drivers were seen to wait for seconds for their turn
/// while their neighbours planned.
class ChildProcess {
 public:
  /// `command`: executable path, then arguments. `environment` is added to this process' own.
  /// Throws std::system_error naming the executable when it cannot be started. Call from a thread
  /// that lives as long as the child shall.
  ChildProcess(const std::vector<std::string>& command,
               const std::map<std::string, std::string>& environment,
               const ProcessorShare& share = {});
  /// Kills the group if the child has not ended, and waits for the child.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  pid_t pid() const { return pid_; }
  /// File descriptor to poll for output.
  int output() const { return output_; }
  /// What it wrote since the last call, without waiting; "" when there is nothing.
  std::string read_output();
  /// Sends a signal to the child and everything in its group. Does nothing once it has ended.
  void send_signal(int signal);
  /// The wait status once the child has ended, without waiting; what is left of its group is
  /// killed.
  std::optional<int> status();
  /// Largest resident memory it had [bytes]; 0 until it has ended.
  std::int64_t peak_memory() const { return peak_memory_; }

 private:
  pid_t pid_ = -1;
  int output_ = -1;
  std::optional<int> status_;
  std::int64_t peak_memory_ = 0;
};

/// "exit code 3" or "signal SIGSEGV".
std::string describe_status(int status);

/// True when the status is exit code 0.
bool is_success(int status);

}  // namespace prehend::launch
