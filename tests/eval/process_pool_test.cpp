#include "eval/process_pool.h"

#include <csignal>
#include <fstream>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

TEST(ProcessPool, DoesEveryTaskOnceAndSurvivesCrashes) {
  const testing::TemporaryFolder folder;
  const auto file_of = [&](int i) { return folder.path / std::to_string(i); };
  PoolProgress last;
  const std::vector<CrashedTask> crashed = run_in_processes(
      20, 3, folder.path / "output.txt",
      [&](int i) {
        if (i == 4) std::raise(SIGKILL);
        if (i == 19) throw std::runtime_error("the last one");
        // Fails when the file is there: a task was done twice.
        if (std::filesystem::exists(file_of(i))) std::raise(SIGKILL);
        std::ofstream(file_of(i)) << i;
      },
      [&](const PoolProgress& progress) { last = progress; });
  ASSERT_EQ(crashed.size(), 2U);
  EXPECT_EQ(crashed[0].task, 4);
  EXPECT_EQ(crashed[0].how.rfind("signal 9", 0), 0U) << crashed[0].how;
  EXPECT_EQ(crashed[1].task, 19);
  EXPECT_EQ(last.done, 20);
  EXPECT_EQ(last.total, 20);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(std::filesystem::exists(file_of(i)), i != 4 && i != 19) << i;
  }
  std::ifstream output(folder.path / "output.txt");
  std::string line;
  std::getline(output, line);
  EXPECT_EQ(line, "task 19: the last one");
}

TEST(ProcessPool, NothingToDoAndBadArguments) {
  const testing::TemporaryFolder folder;
  EXPECT_TRUE(run_in_processes(0, 2, folder.path / "output.txt", [](int) {}).empty());
  EXPECT_THROW(run_in_processes(1, 0, folder.path / "output.txt", [](int) {}),
               std::invalid_argument);
  EXPECT_THROW(run_in_processes(1, 1, folder.path / "no" / "folder", [](int) {}),
               std::runtime_error);
}

}  // namespace
}  // namespace prehend::eval
