#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

namespace prehend::testing {

/// A folder below the system's temporary one that goes with its owner.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A program of build/bin as a child process, its output in a file. Destroying it kills it.
class Launched {
 public:
  /// `arguments` without the program's name. Both output streams go to `output_file`.
  Launched(const std::string& program, const std::vector<std::string>& arguments,
           const std::filesystem::path& output_file);
  ~Launched();
  Launched(const Launched&) = delete;
  Launched& operator=(const Launched&) = delete;

  /// Exit code, 128 + signal for a killed program, nothing when it still runs after `timeout`.
  std::optional<int> wait(std::chrono::seconds timeout);
  /// What the program wrote so far.
  std::string output() const;
  /// True once `text` was written, false when it was not within `timeout` or the program ended.
  bool wait_for_output(const std::string& text, std::chrono::seconds timeout);
  void send_signal(int signal);
  pid_t pid() const { return pid_; }

 private:
  bool has_ended();

  pid_t pid_ = -1;
  std::optional<int> exit_code_;
  std::filesystem::path output_file_;
};

/// Runs a program to its end and returns exit code and output; the code is empty after `timeout`.
struct Outcome {
  std::optional<int> exit_code;
  std::string output;
};
Outcome run_program(const std::string& program, const std::vector<std::string>& arguments,
                    std::chrono::seconds timeout);

/// Direct and indirect children of `pid` whose executable's name is `program`.
std::vector<pid_t> descendants(pid_t pid, const std::string& program);

}  // namespace prehend::testing
