#pragma once

#include <pty.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/tools/virtual_screen.h"

namespace prehend::testing {

/// A program of the build's bin folder in a terminal of 80 x 24 characters; killed at the end.
class PseudoTerminal {
 public:
  PseudoTerminal(const std::string& program, const std::vector<std::string>& arguments,
                 const std::string& registry, const std::string& kind = "xterm") {
    winsize size{};
    size.ws_col = 80;
    size.ws_row = 24;
    const char* folder = std::getenv("PREHEND_BIN");
    const std::string path = std::string(folder ? folder : "build/bin") + "/" + program;
    std::vector<std::string> words = arguments;
    words.insert(words.begin(), path);
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    pid_ = ::forkpty(&side_, nullptr, nullptr, &size);
    if (pid_ == 0) {
      ::setenv("TERM", kind.c_str(), 1);
      ::setenv("PREHEND_REGISTRY", registry.c_str(), 1);
      ::execv(path.c_str(), pointers.data());
      ::_exit(127);
    }
    EXPECT_GT(pid_, 0);
    reader_ = std::thread([this] {
      char bytes[4096];
      for (ssize_t count = ::read(side_, bytes, sizeof bytes); count > 0;
           count = ::read(side_, bytes, sizeof bytes)) {
        const std::lock_guard lock(mutex_);
        wrote_.append(bytes, static_cast<std::size_t>(count));
        screen_.write({bytes, static_cast<std::size_t>(count)});
      }
    });
  }
  ~PseudoTerminal() {
    if (!exit_code_) ::kill(pid_, SIGKILL);
    wait(std::chrono::seconds(10));
    reader_.join();  // the terminal's other side is closed by now
    ::close(side_);
  }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  pid_t pid() const { return pid_; }
  void type(const std::string& keys) {
    EXPECT_EQ(::write(side_, keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
  }
  /// All that the program wrote, what moves the cursor included.
  std::string wrote() const {
    const std::lock_guard lock(mutex_);
    return wrote_;
  }
  /// What is on the screen now.
  std::string shown() const {
    const std::lock_guard lock(mutex_);
    return screen_.text();
  }
  bool shows(const std::string& text, std::chrono::seconds timeout = std::chrono::seconds(15)) {
    const auto end = std::chrono::steady_clock::now() + timeout;
    while (shown().find(text) == std::string::npos) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return true;
  }
  /// Exit code, 128 + the signal that killed it; nothing when it still runs.
  std::optional<int> wait(std::chrono::seconds timeout) {
    const auto end = std::chrono::steady_clock::now() + timeout;
    while (!exit_code_) {
      int status = 0;
      if (::waitpid(pid_, &status, WNOHANG) == pid_) {
        exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        break;
      }
      if (std::chrono::steady_clock::now() > end) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return exit_code_;
  }

 private:
  int side_ = -1;
  pid_t pid_ = -1;
  std::optional<int> exit_code_;
  mutable std::mutex mutex_;
  std::string wrote_;
  VirtualScreen screen_;
  std::thread reader_;
};

}  // namespace prehend::testing
