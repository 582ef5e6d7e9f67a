#pragma once

#include <sys/types.h>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace prehend::testing {

/// A temporary folder that vanishes with the object.
class ScratchDirectory {
 public:
  ScratchDirectory();
  ~ScratchDirectory();
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  std::string path(const std::string& name = "") const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const;

 private:
  std::filesystem::path path_;
};

std::string text_of_file(const std::string& path);

/// A program of the build's bin folder, or of an absolute path, started with its output in a file;
/// killed at the end.
class ChildProgram {
 public:
  ChildProgram(const std::string& program, const std::vector<std::string>& arguments,
               const std::string& output_file, const std::string& registry = "");
  ~ChildProgram();
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  pid_t pid() const { return pid_; }
  std::string output() const { return text_of_file(output_file_); }
  /// Exit code, 128 + number of the signal that killed it, nothing when it still runs.
  std::optional<int> wait(std::chrono::milliseconds timeout);
  /// True once the output holds `text`.
  bool wait_for_output(const std::string& text,
                       std::chrono::milliseconds timeout = std::chrono::seconds(10));

 private:
  pid_t pid_ = -1;
  const std::string output_file_;
  std::optional<int> exit_code_;
};

/// True when the process exists and is no zombie.
bool is_running(pid_t pid);

/// Waits until `condition` holds; false when it does not within the time.
template <class Condition>
bool eventually(Condition condition, std::chrono::milliseconds timeout = std::chrono::seconds(10));

}  // namespace prehend::testing

#include <thread>

template <class Condition>
bool prehend::testing::eventually(Condition condition, std::chrono::milliseconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}
