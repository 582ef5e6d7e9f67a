// Arms with hands pick what a camera sees, as launched for people; judged by what was recorded.

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "msgs/grasp.pb.h"
#include "tests/system/carried.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

/// Launches, waits for the end and gives the exit code; the output in `output`.
int run_launch(const std::string& file, const std::filesystem::path& out,
               const std::vector<std::string>& arguments, std::string* output) {
  std::filesystem::create_directories(out);
  std::vector<std::string> words{"launch", "launch/" + file + ".yaml", "out:=" + out.string(),
                                 "--log-dir", (out / "log").string()};
  words.emplace_back("speed:=0");
  words.insert(words.end(), arguments.begin(), arguments.end());
  Launched launch("prehend", words, out / "output.txt");
  const int code = launch.wait(std::chrono::seconds(120)).value_or(-1);
  EXPECT_TRUE(descendants(launch.pid(), "simulation").empty());
  *output = launch.output();
  return code;
}

class Arm : public ::testing::TestWithParam<std::string> {};

TEST_P(Arm, PicksUpMovesAndPutsDown) {
  const ScratchFolder scratch;
  const auto out = scratch.path() / "out";
  std::string output;
  ASSERT_EQ(run_launch(GetParam(), out, {}, &output), 0) << output;
  const auto recording = read_recording(out / "recording.mcap");
  const Carried carried = carried_body(recording);
  EXPECT_GE(carried.raised, 0.05) << carried.name;
  EXPECT_GE(carried.moved, 0.1) << carried.name;
  EXPECT_LT(carried.last_height, 0.01) << carried.name;
  EXPECT_TRUE(carried.touches_table) << carried.name;
  const auto results = decode_all<msgs::CycleResult>(recording, "/cycle/result");
  ASSERT_EQ(results.size(), 1u);
  EXPECT_EQ(results[0].outcome(), msgs::CycleResult::SUCCEEDED) << results[0].reason();
}

TEST(ArmPlace, TheObjectIsPutWhereItWasTold) {
  const ScratchFolder scratch;
  const auto out = scratch.path() / "out";
  std::string output;
  ASSERT_EQ(run_launch("kth", out, {"scene:=spray_bottle", "place:=0.05,-0.17"}, &output), 0)
      << output;
  const Carried carried = carried_body(read_recording(out / "recording.mcap"));
  EXPECT_GE(carried.raised, 0.05) << carried.name;
  // The middle of the predicted shape.
  EXPECT_NEAR(carried.last_x, 0.05, 0.03);
  EXPECT_NEAR(carried.last_y, -0.17, 0.03);
  EXPECT_TRUE(carried.touches_table) << carried.name;
}

TEST(ArmPlace, AnOccupiedOneIsRefusedBeforeAnythingMoves) {
  const ScratchFolder scratch;
  std::string output;
  EXPECT_NE(run_launch("kth", scratch.path() / "out", {"place:=-0.06,0.2"}, &output), 0);
  EXPECT_NE(output.find("the place -0.060, 0.200 is occupied by what stands at"), std::string::npos)
      << output;
  EXPECT_EQ(output.find("opening the hand"), std::string::npos) << output;
}

INSTANTIATE_TEST_SUITE_P(Launches, Arm, ::testing::Values("kth", "uji"));

}  // namespace
}  // namespace prehend::testing
