// Arms with hands pick what a camera sees, as launched for people; judged by what was recorded.

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "msgs/grasp.pb.h"
#include "tests/system/carried.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

class Arm : public ::testing::TestWithParam<std::string> {};

TEST_P(Arm, PicksUpMovesAndPutsDown) {
  const ScratchFolder scratch;
  const auto out = scratch.path() / "out";
  std::filesystem::create_directories(out);
  {
    Launched launch("prehend",
                    {"launch", "launch/" + GetParam() + ".yaml", "out:=" + out.string(),
                     "--log-dir", (out / "log").string()},
                    scratch.path() / "output.txt");
    ASSERT_EQ(launch.wait(std::chrono::seconds(120)), 0) << launch.output();
    EXPECT_TRUE(descendants(launch.pid(), "simulation").empty());
  }
  const auto recording = read_recording(out / "recording.mcap");
  const Carried carried = carried_body(recording);
  EXPECT_GE(carried.raised, 0.05) << carried.name;
  EXPECT_GE(carried.moved, 0.1) << carried.name;
  EXPECT_LT(carried.last_height, 0.01) << carried.name;
  EXPECT_TRUE(carried.touches_table) << carried.name;
  const auto results = decode_all<msgs::CycleResult>(recording, "/cycle/result");
  ASSERT_EQ(results.size(), 1u);
  EXPECT_TRUE(results[0].success()) << results[0].reason();
}

INSTANTIATE_TEST_SUITE_P(Launches, Arm, ::testing::Values("kth", "uji"));

}  // namespace
}  // namespace prehend::testing
