// Every robot of config/robots picks what a simulated camera sees, as launched for people, as fast
// as it can, and every fifth one (with PREHEND_THOROUGH_TESTS in the environment all) what a
// recorded cloud shows; judged by what was recorded.

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "msgs/grasp.pb.h"
#include "prehend/robot/robot_files.h"
#include "tests/system/carried.h"
#include "tests/system/launched.h"
#include "tests/system/recorded_box.h"

namespace prehend::testing {
namespace {

std::vector<std::string> all_platforms() { return robot::platform_names("config/robots"); }

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

class Platform : public ::testing::TestWithParam<std::string> {
 protected:
  Outcome launch(const std::string& file, const std::vector<std::string>& more) const {
    std::filesystem::create_directories(out_);
    std::vector<std::string> words{"launch",    "launch/" + file,       "platform:=" + GetParam(),
                                   "speed:=0",  "record:=true",         "out:=" + out_.string(),
                                   "--log-dir", (out_ / "log").string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_program("prehend", words, std::chrono::seconds(120));
  }

  void expect_picked_and_drawn() const {
    const auto recording = read_recording(out_ / "recording.mcap");
    const Carried carried = carried_body(recording);
    EXPECT_GE(carried.raised, 0.05) << carried.name;
    EXPECT_GE(carried.moved, 0.08) << carried.name;
    EXPECT_LT(carried.last_height, 0.01) << carried.name;
    EXPECT_TRUE(carried.touches_table) << carried.name;
    const auto results = decode_all<msgs::CycleResult>(recording, "/cycle/result");
    ASSERT_EQ(results.size(), 1u);
    EXPECT_EQ(results[0].outcome(), msgs::CycleResult::SUCCEEDED) << results[0].reason();
    const std::string page = text_of(out_ / "report.html");
    std::vector<std::string> parts{"Completed cloud", "Mesh", "Grasp 1", "Forces", "Stage times"};
    if (GetParam() != "stage_pg70") {
      parts.insert(parts.end(), {"The arm at the grasp", "Joints of the hand."});
    }
    for (const std::string& part : parts) {
      EXPECT_NE(page.find(part), std::string::npos) << part;
    }
    EXPECT_EQ(page.find("could not be drawn"), std::string::npos);
  }

  ScratchFolder scratch_;
  const std::filesystem::path out_ = scratch_.path() / "out";
};

TEST_P(Platform, PicksWhatASimulatedCameraSees) {
  const Outcome outcome = launch("demo.yaml", {});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  expect_picked_and_drawn();
}

class PlatformWithCloud : public Platform {};

TEST_P(PlatformWithCloud, PicksWhatARecordedCloudShows) {
  const auto cloud = scratch_.path() / "box.pcd";
  std::ofstream(cloud) << image_of_a_box({0.05, 0.06, 0.12});
  const Outcome outcome = launch("replay_cloud.yaml", {"cloud:=" + cloud.string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("executed on the predicted mesh"), std::string::npos);
  expect_picked_and_drawn();
}

INSTANTIATE_TEST_SUITE_P(All, Platform, ::testing::ValuesIn(all_platforms()),
                         [](const auto& info) { return info.param; });

std::vector<std::string> platforms_with_cloud() {
  std::vector<std::string> some;
  const std::size_t step = std::getenv("PREHEND_THOROUGH_TESTS") ? 1 : 5;
  const std::vector<std::string> all = all_platforms();
  for (std::size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

INSTANTIATE_TEST_SUITE_P(Some, PlatformWithCloud, ::testing::ValuesIn(platforms_with_cloud()),
                         [](const auto& info) { return info.param; });

TEST(UnknownPlatform, IsRefusedWithTheNearest) {
  const ScratchFolder scratch;
  const Outcome outcome = run_program(
      "prehend",
      {"launch", "launch/demo.yaml", "platform:=kr5_sdhh", "out:=" + scratch.path().string(),
       "--log-dir", (scratch.path() / "log").string()},
      std::chrono::seconds(60));
  EXPECT_TRUE(outcome.exit_code) << "still running";
  EXPECT_NE(outcome.exit_code, 0);
  EXPECT_NE(outcome.output.find("There is no platform 'kr5_sdhh'"), std::string::npos)
      << outcome.output;
  EXPECT_NE(outcome.output.find("The nearest is 'kr5_sdh'"), std::string::npos) << outcome.output;
}

}  // namespace
}  // namespace prehend::testing
