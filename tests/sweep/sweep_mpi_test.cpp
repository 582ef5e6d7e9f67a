// prehend sweep --mpi under a real mpirun on the loopback: the same bytes as without, after cases
// and ranks were killed, too; and nothing is left running.

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <utility>
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

class SweepMpiRefused : public SweepRuns {};

#ifdef PREHEND_HAS_MPI

class SweepMpi : public SweepRuns {
 protected:
  void SetUp() override {
    if (std::system("command -v mpirun >/dev/null 2>&1") != 0) {
      GTEST_SKIP() << "mpirun is not installed (apt install openmpi-bin)";
    }
    setenv("OMPI_MCA_btl_base_warn_component_unused", "0", 1);
  }

  /// For /usr/bin/env: so many ranks of a sweep.
  std::vector<std::string> ranks(int count, const std::string& out,
                                 const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{"mpirun", "--oversubscribe", "-n", std::to_string(count)};
    for (const char* word : {"--mca", "btl", "self,vader,tcp", "--mca", "btl_tcp_if_include", "lo",
                             "--mca", "oob_tcp_if_include", "lo"}) {
      all.push_back(word);
    }
    if (geteuid() == 0) all.push_back("--allow-run-as-root");
    all.push_back(std::string(std::getenv("PREHEND_BIN")) + "/prehend");
    std::vector<std::string> more_with_mpi{"--mpi"};
    more_with_mpi.insert(more_with_mpi.end(), more.begin(), more.end());
    const std::vector<std::string> sweep = words(out, more_with_mpi);
    all.insert(all.end(), sweep.begin(), sweep.end());
    return all;
  }
  std::string run_ranks(int count, const std::string& out,
                        const std::vector<std::string>& more = {}) {
    return end_of("/usr/bin/env", ranks(count, out, more));
  }
  /// Cases that last long enough for what is done to ranks meanwhile.
  void make_longer() {
    std::string text = kSweep;
    text.replace(text.find("sleep 0.2"), 9, "sleep 0.6");
    description_ = folder_.write("long.yaml", text);
  }

  ChildProgram started(int count, const std::string& out,
                       const std::vector<std::string>& more = {}) {
    return {"/usr/bin/env", ranks(count, out, more), folder_.path("started")};
  }

  /// Its processes by their number, while they run.
  static std::map<int, pid_t> ranks_of(pid_t mpirun) {
    std::map<int, pid_t> found;
    std::error_code error;  // it may end
    for (const auto& task :
         fs::directory_iterator("/proc/" + std::to_string(mpirun) + "/task", error)) {
      std::ifstream children(task.path() / "children");
      for (pid_t child = 0; children >> child;) {
        const std::string environment = text_of_file("/proc/" + std::to_string(child) + "/environ");
        const std::string name = "OMPI_COMM_WORLD_RANK=";
        const std::size_t at = environment.find(name);
        if (at == std::string::npos) continue;
        found[std::atoi(environment.c_str() + at + name.size())] = child;
      }
    }
    return found;
  }

  void expect_nothing_runs(const std::map<int, pid_t>& ranks,
                           const std::map<std::string, pid_t>& cases) {
    for (const auto& [number, one] : ranks) {
      EXPECT_TRUE(eventually([one = one] { return !is_running(one); })) << "rank " << number;
    }
    for (const auto& [folder, one] : cases) {
      EXPECT_TRUE(eventually([one = one] { return !is_running(one); })) << folder;
    }
  }
};

TEST_F(SweepMpi, RanksGiveTheSameBytesAsProcessesOfOne) {
  run("whole", {"--workers", "4"});
  const std::string whole = csv("whole");
  EXPECT_EQ(std::count(whole.begin(), whole.end(), '\n'), 1 + 2 * 24);
  for (const int count : {2, 4}) {
    const std::string out = "ranks" + std::to_string(count);
    const std::string file = folder_.path(out + "_at_once.csv");
    EXPECT_THAT(run_ranks(count, out, {"--export", file}),
                HasSubstr("with " + std::to_string(count - 1) + " workers: 24 done, 0 failed"));
    EXPECT_EQ(exit_code_, 0);
    EXPECT_EQ(text_of_file(file), whole) << count;
    EXPECT_THAT(run_ranks(count, out), HasSubstr("Nothing is open"));
    EXPECT_EQ(exit_code_, 0);
  }
}

TEST_F(SweepMpi, WhatFailsIsSaidWithItsOutput) {
  description_ = folder_.write("f.yaml", R"(
program: /bin/sh
arguments: [-c, 'echo about to {how}; case {how} in fail) exit 4;; hang) sleep 60;; esac; echo v=1']
grid: {how: [work, fail, hang]}
results: {output: {v: 'v=(\d)'}}
timeout: 1
)");
  EXPECT_THAT(run_ranks(3, "f"),
              AllOf(HasSubstr("1 done, 2 failed"), HasSubstr("how=fail: exit status 4"),
                    HasSubstr("about to fail"), HasSubstr("how=hang: It took longer")));
  EXPECT_EQ(exit_code_, 1);
}

TEST_F(SweepMpi, KilledCasesAreGivenOutAgain) {
  run("whole", {"--workers", "4"});
  ChildProgram program = started(4, "killed");
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
  EXPECT_THAT(program.output(), HasSubstr("24 done, 0 failed"));
  EXPECT_EQ(csv("killed"), csv("whole"));
}

TEST_F(SweepMpi, AKilledRankEndsTheJobAndTheNextStartGoesOn) {
  run("whole", {"--workers", "4"});
  for (const int number : {2, 0}) {
    ChildProgram program = started(3, "ended");
    ASSERT_TRUE(eventually([&] { return has_begun("ended"); })) << program.output();
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    const auto ranks = ranks_of(program.pid());
    const auto cases = cases_of("ended");
    ASSERT_EQ(ranks.size(), 3U) << program.output();
    ::kill(ranks.at(number), SIGKILL);
    ASSERT_TRUE(program.wait(std::chrono::seconds(20)));
    EXPECT_NE(program.wait(std::chrono::seconds(1)), 0);
    expect_nothing_runs(ranks, cases);
  }
  EXPECT_THAT(run_ranks(3, "ended"), Not(HasSubstr("of 24 cases ran"))) << "some were done before";
  EXPECT_EQ(exit_code_, 0);
  EXPECT_EQ(csv("ended"), csv("whole"));
}

TEST_F(SweepMpi, ASignalAtTheFirstRankOrTheLauncherEndsAllInOrder) {
  run("whole", {"--workers", "4"});
  for (const int signal : {SIGINT, SIGTERM}) {
    ChildProgram program = started(3, "ended");
    ASSERT_TRUE(eventually([&] { return has_begun("ended"); })) << program.output();
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    const auto ranks = ranks_of(program.pid());
    const auto cases = cases_of("ended");
    ASSERT_EQ(ranks.size(), 3U) << program.output();
    ::kill(ranks.at(0), signal);
    EXPECT_EQ(program.wait(std::chrono::seconds(20)), 130);
    EXPECT_THAT(program.output(),
                AllOf(HasSubstr("Stopped. What ended is kept"), Not(HasSubstr("MPI_Abort"))));
    expect_nothing_runs(ranks, cases);
  }
  ChildProgram program = started(3, "ended");
  ASSERT_TRUE(eventually([&] { return has_begun("ended"); })) << program.output();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const auto ranks = ranks_of(program.pid());
  const auto cases = cases_of("ended");
  ::kill(program.pid(), SIGINT);
  ASSERT_TRUE(program.wait(std::chrono::seconds(20)));
  expect_nothing_runs(ranks, cases);
  EXPECT_THAT(run_ranks(3, "ended"), Not(HasSubstr("of 24 cases ran"))) << "some were done before";
  EXPECT_EQ(exit_code_, 0);
  EXPECT_EQ(csv("ended"), csv("whole"));
}

TEST_F(SweepMpi, ASilentRankIsLostAndItsCaseGivenOutAgain) {
  run("whole", {"--workers", "4"});
  ChildProgram program = started(4, "silent", {"--lost-after", "2"});
  ASSERT_TRUE(eventually([&] { return cases_of("silent").size() == 3; })) << program.output();
  const auto ranks = ranks_of(program.pid());
  ASSERT_EQ(ranks.size(), 4U) << program.output();
  ::kill(ranks.at(2), SIGSTOP);
  EXPECT_EQ(program.wait(std::chrono::seconds(40)), 0);
  EXPECT_THAT(program.output(), AllOf(HasSubstr("Rank 2"), HasSubstr("is lost"),
                                      HasSubstr("with 2 workers: 24 done, 0 failed")));
  expect_nothing_runs(ranks, cases_of("silent"));
  EXPECT_EQ(csv("silent"), csv("whole"));
}

TEST_F(SweepMpi, ALostRankThatComesBackEndsInOrder) {
  make_longer();
  run("whole", {"--workers", "8"});
  ChildProgram program = started(4, "silent", {"--lost-after", "2"});
  ASSERT_TRUE(eventually([&] { return cases_of("silent").size() == 3; })) << program.output();
  const auto ranks = ranks_of(program.pid());
  ASSERT_EQ(ranks.size(), 4U) << program.output();
  ::kill(ranks.at(3), SIGSTOP);
  EXPECT_TRUE(program.wait_for_output("is lost")) << program.output();
  ::kill(ranks.at(3), SIGCONT);
  EXPECT_EQ(program.wait(std::chrono::seconds(40)), 0);
  EXPECT_THAT(program.output(),
              AllOf(HasSubstr("with 2 workers: 24 done, 0 failed"), Not(HasSubstr("MPI_Abort"))));
  expect_nothing_runs(ranks, cases_of("silent"));
  EXPECT_EQ(csv("silent"), csv("whole"));
}

TEST_F(SweepMpi, ARankThatIsAskedToEndDoesSoAndTheOthersGoOn) {
  run("whole", {"--workers", "4"});
  ChildProgram program = started(4, "fewer");
  ASSERT_TRUE(eventually([&] { return cases_of("fewer").size() == 3; })) << program.output();
  const auto ranks = ranks_of(program.pid());
  ASSERT_EQ(ranks.size(), 4U) << program.output();
  ::kill(ranks.at(1), SIGTERM);
  EXPECT_EQ(program.wait(std::chrono::seconds(40)), 0);
  EXPECT_THAT(program.output(), AllOf(HasSubstr("ended before the others"),
                                      HasSubstr("with 2 workers: 24 done, 0 failed")));
  expect_nothing_runs(ranks, cases_of("fewer"));
  EXPECT_EQ(csv("fewer"), csv("whole"));
}

TEST_F(SweepMpi, WhatGoesWrongAtARankIsSaidByTheFirst) {
  folder_.write("wrong/cases", "a file where the cases' folders should be");
  EXPECT_THAT(run_ranks(3, "wrong"),
              AllOf(HasSubstr("prehend sweep: Rank "), HasSubstr("cannot be made"),
                    HasSubstr("Name another --out")));
  EXPECT_EQ(exit_code_, 1);
}

TEST_F(SweepMpi, WrongInputIsSaidOnceAndEndsAllRanks) {
  description_ = folder_.path("none.yaml");
  const std::string said = run_ranks(4, "wrong");
  EXPECT_EQ(exit_code_, 1);
  const std::size_t at = said.find("none.yaml");
  ASSERT_NE(at, std::string::npos) << said;
  EXPECT_EQ(said.find("prehend sweep: ", at), std::string::npos) << said;
}

TEST_F(SweepMpi, OneRankIsRefused) {
  EXPECT_THAT(run_ranks(1, "one"), AllOf(HasSubstr("two ranks or more"), HasSubstr("mpirun -n 5")));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_FALSE(fs::exists(folder_.path("one")));
}

TEST_F(SweepMpiRefused, WithoutALauncher) {
  EXPECT_THAT(run("one", {"--mpi"}), AllOf(HasSubstr("two ranks or more"), HasSubstr("mpirun -n")));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_FALSE(fs::exists(folder_.path("one")));
}

#else

TEST_F(SweepMpiRefused, WithTheNamesOfThePackages) {
  EXPECT_THAT(run("one", {"--mpi"}), AllOf(HasSubstr("without MPI"), HasSubstr("libboost-mpi-dev"),
                                           HasSubstr("openmpi-bin"), HasSubstr("libopenmpi-dev")));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_FALSE(fs::exists(folder_.path("one")));
}

#endif

TEST_F(SweepMpiRefused, BesideWhatHandsOutNothing) {
  const std::vector<std::vector<std::string>> others{{"--list"},       {"--status"},
                                                     {"--merge"},      {"--part", "1/2"},
                                                     {"--slurm", "2"}, {"--workers", "2"}};
  for (std::vector<std::string> words : others) {
    const std::string other = words.front();
    words.push_back("--mpi");
    EXPECT_THAT(run("other", words), AllOf(HasSubstr("--mpi"), HasSubstr(other))) << other;
    EXPECT_NE(exit_code_, 0) << other;
  }
  EXPECT_FALSE(fs::exists(folder_.path("other")));
  EXPECT_THAT(run("other", {"--lost-after", "9"}), HasSubstr("--mpi"));
  EXPECT_NE(exit_code_, 0);
}

}  // namespace
}  // namespace prehend::testing
