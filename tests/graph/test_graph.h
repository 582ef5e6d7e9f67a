#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "msgs/graph.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"

namespace prehend::graph {

using namespace std::chrono_literals;

/// Waits until `condition` holds; false after `timeout`.
inline bool eventually(const std::function<bool()>& condition,
                       std::chrono::milliseconds timeout = 5s) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(2ms);
  }
  return true;
}

inline msgs::Clock clock_message(std::int64_t time) {
  msgs::Clock message;
  message.set_time(time);
  return message;
}

/// A registry of the test's own, and nodes of it.
class GraphTest : public testing::Test {
 protected:
  NodeOptions options(const std::string& name) const {
    NodeOptions result;
    result.name = name;
    result.registry = endpoint;
    return result;
  }

  std::unique_ptr<Registry> registry =
      std::make_unique<Registry>(RegistryOptions{.endpoint = "tcp://127.0.0.1:*"});
  std::string endpoint = registry->endpoint();
};

/// The messages a subscription got. Thread-safe.
class Inbox {
 public:
  void add(std::int64_t value) {
    const std::lock_guard lock(mutex_);
    values_.push_back(value);
  }
  std::vector<std::int64_t> values() const {
    const std::lock_guard lock(mutex_);
    return values_;
  }
  std::size_t size() const { return values().size(); }
  std::function<void(const Received<msgs::Clock>&)> taker() {
    return [this](const Received<msgs::Clock>& m) { add(m->time()); };
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::int64_t> values_;
};

/// The lines on /log. Has a node of its own.
class LogReader {
 public:
  explicit LogReader(NodeOptions options) : node_(std::move(options)) {
    subscription_ = node_.subscribe<msgs::graph::LogLine>(
        "/log", QoS::queue(1000), [this](const Received<msgs::graph::LogLine>& m) {
          const std::lock_guard lock(mutex_);
          lines_.push_back(m->node() + ": " + m->text());
        });
    node_.spin_in_background();
  }
  std::size_t count(const std::string& part) const {
    const std::lock_guard lock(mutex_);
    std::size_t result = 0;
    for (const auto& line : lines_) result += line.find(part) != std::string::npos ? 1 : 0;
    return result;
  }
  bool has(const std::string& part) const { return count(part) > 0; }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> lines_;
  Node node_;
  Subscription subscription_;
};

/// A process running the program graph_test_node beside this test's program.
class Child {
 public:
  explicit Child(std::vector<std::string> arguments) {
    const auto program =
        std::filesystem::read_symlink("/proc/self/exe").parent_path() / "graph_test_node";
    arguments.insert(arguments.begin(), program.string());
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ == 0) {
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
  }
  ~Child() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      wait();
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  pid_t pid() const { return pid_; }
  void send(int signal) const { ::kill(pid_, signal); }
  /// Exit code, or -signal.
  int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t pid_ = -1;
};

}  // namespace prehend::graph
