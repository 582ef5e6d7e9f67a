// prehend sweep, as a user runs it: the same bytes whoever ran what, and after what was killed.

#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/launch/child_program.h"
#include "tests/sweep/sweep_runs.h"

namespace prehend::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class SweepCommand : public SweepRuns {};

TEST_F(SweepCommand, OneWorkerOrManyOrPartsGiveTheSameBytes) {
  EXPECT_THAT(run("one", {"--workers", "1"}), HasSubstr("24 done, 0 failed"));
  EXPECT_EQ(exit_code_, 0);
  run("four", {"--workers", "4"});
  for (const char* part : {"2/3", "1/3", "3/3"}) run("parts", {"--workers", "3", "--part", part});
  const std::string one = csv("one");
  EXPECT_EQ(std::count(one.begin(), one.end(), '\n'), 1 + 2 * 24);
  EXPECT_EQ(csv("four"), one);
  EXPECT_EQ(csv("parts"), one) << "before they are merged";
  EXPECT_THAT(run("parts", {"--merge"}), HasSubstr("24 done, 0 failed, 0 open"));
  EXPECT_EQ(exit_code_, 0);
  EXPECT_EQ(csv("parts"), one);
  EXPECT_THAT(run("one", {}), HasSubstr("Nothing is open: each case has its result"));
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(run("one", {"--only", "nothing*"}), HasSubstr("No case has a name like 'nothing*'"));
  EXPECT_EQ(exit_code_, 1);
}

TEST_F(SweepCommand, KilledCasesAreGivenOutAgain) {
  run("whole", {"--workers", "4"});
  ChildProgram program("prehend", words("killed", {"--workers", "3"}), folder_.path("output"));
  std::set<std::string> killed;  // each once: what is killed three times has failed
  while (!program.wait(std::chrono::milliseconds(80))) {
    if (killed.size() >= 5 || !has_begun("killed")) continue;
    for (const auto& [folder, one] : cases_of("killed")) {
      if (!killed.insert(folder).second) continue;
      ::kill(-one, SIGKILL);
      break;
    }
  }
  EXPECT_GE(killed.size(), 3U);
  EXPECT_EQ(program.wait(std::chrono::seconds(1)), 0) << program.output();
  EXPECT_EQ(csv("killed"), csv("whole"));
}

TEST_F(SweepCommand, GoesOnWhereItWasKilledAndLeavesNothingRunning) {
  run("whole", {"--workers", "4"});
  for (const int signal : {SIGKILL, SIGINT}) {
    ChildProgram program("prehend", words("ended", {"--workers", "3"}), folder_.path("output"));
    ASSERT_TRUE(eventually([&] { return has_begun("ended"); }));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    const auto running = cases_of("ended");
    ::kill(program.pid(), signal);
    ASSERT_TRUE(program.wait(std::chrono::seconds(10)));
    for (const auto& [folder, one] : running) {
      EXPECT_TRUE(eventually([one = one] { return !is_running(one); })) << folder;
    }
  }
  run("ended", {"--workers", "3"});
  EXPECT_EQ(exit_code_, 0);
  EXPECT_EQ(csv("ended"), csv("whole"));
}

TEST_F(SweepCommand, ASecondOneInTheFolderIsRefused) {
  ChildProgram first("prehend", words("shared", {"--workers", "2"}), folder_.path("first"));
  ASSERT_TRUE(eventually([&] { return has_begun("shared"); }));
  EXPECT_THAT(run("shared", {}), HasSubstr("in use"));
  EXPECT_NE(exit_code_, 0);
  EXPECT_THAT(run("shared", {"--status"}), HasSubstr("24 cases")) << "to look is allowed";
  EXPECT_EQ(first.wait(std::chrono::seconds(30)), 0);
}

TEST_F(SweepCommand, WhatFailsIsSaidWithItsOutputAndRunAgainAlone) {
  description_ = folder_.write("f.yaml", R"(
program: /bin/sh
arguments: [-c, 'echo about to {how}; case {how} in fail) exit 4;; hang) sleep 60;; crash) kill -SEGV $$;; esac; echo v=1']
grid: {how: [work, fail, hang, crash, mute]}
results: {output: {v: 'v=(\d)'}}
timeout: 1
)");
  const std::string output = run("f", {"--workers", "5"});
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(output, AllOf(HasSubstr("2 done, 3 failed"), HasSubstr("how=fail: exit status 4"),
                            HasSubstr("about to fail"), HasSubstr("how=hang: It took longer"),
                            HasSubstr("how=crash: signal 11")));
  // Regression: when it was run once more it ended with 0, and said that each had its result.
  EXPECT_THAT(run("f", {}), AllOf(HasSubstr("Nothing is open, and not each case has a result"),
                                  HasSubstr("how=fail: exit status 4")));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(run("f", {"--only", "how=work"}), HasSubstr("each case has its result"));
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(run("f", {"--again", "how=fail"}), HasSubstr("1 of 1 cases ran"));
  EXPECT_THAT(run("f", {"--again", "how=nothing"}), HasSubstr("No case is named"));
}

TEST_F(SweepCommand, WrongWordsAreRefusedBeforeAnythingRuns) {
  EXPECT_THAT(run("x", {"--export", "table.xls"}), HasSubstr(".csv or .h5"));
  EXPECT_NE(exit_code_, 0);
  EXPECT_THAT(run("x", {"--export-costs", "costs.h5"}), HasSubstr("Name a .csv file"));
  EXPECT_NE(exit_code_, 0);
  EXPECT_THAT(run("x", {"--part", "4/3"}), HasSubstr("no part"));
  EXPECT_FALSE(fs::exists(folder_.path("x") + "/cases"));
  description_ = folder_.write(
      "g.yaml", "program: no_such_program\narguments: ['{a}']\ngrid: {a: [1]}\nresults: none\n");
  EXPECT_THAT(run("y", {}), HasSubstr("no_such_program"));
  EXPECT_NE(exit_code_, 0);
  description_ = folder_.path("none.yaml");
  EXPECT_THAT(run("y", {}), HasSubstr("none.yaml"));
}

}  // namespace
}  // namespace prehend::testing
