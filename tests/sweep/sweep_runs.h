#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/launch/child_program.h"

namespace prehend::testing {

// 24 cases of a shell's `sleep`, which leave a table of two rows and their process in a file.
inline constexpr const char* kSweep = R"(
program: /bin/sh
arguments:
  - -c
  - 'echo $$ > {folder}/process; sleep 0.2; printf "row,figure\n1,{a}\n2,{x}\n" > {folder}/r.csv'
grid: {a: {from: 1, to: 8}}
sample: {count: 3, seed: 2, x: {log_uniform: [0.01, 10]}}
results: {csv: r.csv}
timeout: 20
)";

/// Sweeps in a folder of the test, as a user runs them.
class SweepRuns : public ::testing::Test {
 protected:
  std::vector<std::string> words(const std::string& out, std::vector<std::string> more) const {
    std::vector<std::string> all{"sweep", description_, "--out", folder_.path(out)};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// The output; the exit code is in exit_code_.
  std::string run(const std::string& out, std::vector<std::string> more) {
    return end_of("prehend", words(out, std::move(more)));
  }
  std::string end_of(const std::string& started, const std::vector<std::string>& words) {
    ChildProgram program(started, words, folder_.path("output"));
    exit_code_ = program.wait(std::chrono::seconds(60)).value_or(-1);
    return program.output();
  }
  std::string csv(const std::string& out) {
    run(out, {"--status", "--export", folder_.path(out + ".csv")});
    return text_of_file(folder_.path(out + ".csv"));
  }
  /// Processes of cases that run now, by the cases' folders.
  std::map<std::string, pid_t> cases_of(const std::string& out) const {
    std::map<std::string, pid_t> running;
    std::error_code error;  // there is none yet
    for (const auto& entry :
         std::filesystem::directory_iterator(folder_.path(out) + "/cases", error)) {
      const std::string text = text_of_file(entry.path() / "process");
      const pid_t one = text.empty() ? 0 : std::stoi(text);
      if (one > 0 && is_running(one)) running[entry.path()] = one;
    }
    return running;
  }
  bool has_begun(const std::string& out) const { return !cases_of(out).empty(); }

  ScratchDirectory folder_;
  std::string description_ = folder_.write("s.yaml", kSweep);
  int exit_code_ = -1;
};

}  // namespace prehend::testing
