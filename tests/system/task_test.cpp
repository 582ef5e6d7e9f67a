// The tasks of config/tasks on the robots of config/robots, as launched for people, as fast as they
// can; judged by what was recorded. Each task and each robot is in one launch at least; with
// PREHEND_THOROUGH_TESTS in the environment every task runs on every robot.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "msgs/grasp.pb.h"
#include "prehend/control/task.h"
#include "prehend/robot/robot_files.h"
#include "tests/system/carried.h"
#include "tests/system/launched.h"
#include "tests/system/recorded_box.h"

namespace prehend::testing {
namespace {

using PlatformAndTask = std::pair<std::string, std::string>;

std::vector<PlatformAndTask> launches() {
  const std::vector<std::string> platforms = robot::platform_names("config/robots");
  const std::vector<std::string> tasks = control::task_names("config/tasks");
  std::vector<PlatformAndTask> pairs;
  if (std::getenv("PREHEND_THOROUGH_TESTS")) {
    for (const std::string& platform : platforms)
      for (const std::string& task : tasks) pairs.emplace_back(platform, task);
  } else {
    for (std::size_t i = 0; i < std::max(platforms.size(), tasks.size()); ++i)
      pairs.emplace_back(platforms[i % platforms.size()], tasks[i % tasks.size()]);
  }
  return pairs;
}

std::string page_text(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

class TaskOnPlatform : public ::testing::TestWithParam<PlatformAndTask> {};

// On a recorded cloud, as that is quick. One object: a task of all finds none left then.
TEST_P(TaskOnPlatform, IsDoneAndDrawn) {
  const auto& [platform, task] = GetParam();
  const ScratchFolder scratch;
  const std::filesystem::path out = scratch.path() / "out";
  std::filesystem::create_directories(out);
  const auto cloud = scratch.path() / "box.pcd";
  std::ofstream(cloud) << image_of_a_box({0.05, 0.06, 0.12});
  const Outcome outcome =
      run_program("prehend",
                  {"launch", "launch/replay_cloud.yaml", "cloud:=" + cloud.string(),
                   "platform:=" + platform, "task:=" + task, "speed:=0", "record:=true",
                   "out:=" + out.string(), "--log-dir", (out / "log").string()},
                  std::chrono::seconds(120));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const auto recording = read_recording(out / "recording.mcap");
  const Carried carried = carried_body(recording);
  const bool places = task != "work_cycle" && task != "shake_test" && task != "inspect";
  EXPECT_GE(carried.raised, 0.05);
  EXPECT_LT(carried.last_height, 0.01);
  if (places) {
    EXPECT_GE(carried.moved, 0.08);
  } else {
    EXPECT_LT(carried.moved, 0.08) << "it is put back where the hand had gathered it";
  }
  const auto results = decode_all<msgs::CycleResult>(recording, "/cycle/result");
  ASSERT_EQ(results.size(), 1u);
  EXPECT_EQ(results[0].outcome(), msgs::CycleResult::SUCCEEDED) << results[0].reason();
  EXPECT_EQ(results[0].placed(), places ? 1u : 0u);
  ASSERT_GT(results[0].task_path_size(), 2);
  EXPECT_EQ(results[0].task_path(0), "look");
  EXPECT_EQ(results[0].task_path(results[0].task_path_size() - 1), "success");
  const std::string page = page_text(out / "report.html");
  EXPECT_NE(page.find("with the path that was taken"), std::string::npos);
  const std::size_t undrawn = page.find("could not be drawn");
  EXPECT_EQ(undrawn, std::string::npos) << page.substr(std::min(undrawn, page.size()), 300);
}

INSTANTIATE_TEST_SUITE_P(All, TaskOnPlatform, ::testing::ValuesIn(launches()),
                         [](const auto& info) {
                           return info.param.first + "_" + info.param.second;
                         });

TEST(UnknownTask, IsRefusedBeforeAnythingMoves) {
  const ScratchFolder scratch;
  const Outcome outcome = run_program(
      "prehend",
      {"launch", "launch/demo.yaml", "task:=work_cylce", "out:=" + scratch.path().string(),
       "--log-dir", (scratch.path() / "log").string()},
      std::chrono::seconds(60));
  ASSERT_TRUE(outcome.exit_code) << "still running";
  EXPECT_NE(outcome.exit_code, 0);
  EXPECT_NE(outcome.output.find("The nearest is 'work_cycle'"), std::string::npos)
      << outcome.output;
}

}  // namespace
}  // namespace prehend::testing
