#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <iterator>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "tests/launch/child_program.h"

namespace prehend::testing {

/// Launches of the program launch_test_node, which does what its parameters say.
class SupervisionTest : public ::testing::Test {
 protected:
  // A launch of `nodes` with a registry of its own.
  std::unique_ptr<ChildProgram> launch(const std::string& nodes) {
    const std::string file = scratch_.write("launch/a.yaml", "nodes:\n" + nodes);
    return std::make_unique<ChildProgram>(
        "prehend",
        std::vector<std::string>{"launch", file, "--log-dir", scratch_.path("log"), "--registry",
                                 "tcp://127.0.0.1:*"},
        scratch_.path("output.txt"));
  }
  std::string node(const std::string& name, const std::string& parameters,
                   const std::string& more = "") {
    return "  - {node: launch_test_node, name: " + name + ", parameters: {touch: " + pids_file() +
           ", " + parameters + "}" + (more.empty() ? "" : ", " + more) + "}\n";
  }
  std::string pids_file() { return scratch_.path("pids"); }
  // Of every test node that was started so far.
  std::vector<pid_t> pids() {
    std::istringstream text(text_of_file(pids_file()));
    return {std::istream_iterator<pid_t>(text), {}};
  }
  bool wait_for_pids(std::size_t count) {
    return eventually([&] { return pids().size() >= count; });
  }
  void expect_none_running() {
    for (const pid_t pid : pids()) {
      EXPECT_TRUE(eventually([&] { return !is_running(pid); }, std::chrono::seconds(2))) << pid;
    }
  }

  ScratchDirectory scratch_;
};

}  // namespace prehend::testing
