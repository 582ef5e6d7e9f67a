// A simulation as fast as it goes, and a recorder that is to lose nothing.

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "msgs/sensors.pb.h"
#include "prehend/recording/mcap_reader.h"
#include "tests/system/launched.h"
#include "tests/system/recording.h"

namespace prehend::testing {
namespace {

// 533 messages were lost of a run like this.
TEST(Lossless, TheFastestSimulationWaitsForItsRecorder) {
  const ScratchFolder scratch;
  const auto file = scratch.path() / "run.mcap";
  const auto launch_file = scratch.path() / "launch" / "fast.yaml";
  std::filesystem::create_directories(launch_file.parent_path());
  std::ofstream(launch_file) << "clock: simulated\n"
                                "nodes:\n"
                                "  - {node: recorder, parameters: {output: "
                             << file.string()
                             << ", compression: zstd}}\n"
                                "  - node: simulation\n"
                                "    after: [recorder]\n"
                                "    parameters: {scene: "
                             << std::filesystem::absolute("config/scenes/demo.yaml").string()
                             << ", speed: 0, camera: false}\n";
  {
    Launched launch("prehend",
                    {"launch", launch_file.string(), "--registry", "tcp://127.0.0.1:*", "--log-dir",
                     (scratch.path() / "log").string()},
                    scratch.path() / "output.txt");
    ASSERT_TRUE(launch.wait_for_output("ready after", std::chrono::seconds(60))) << launch.output();
    std::this_thread::sleep_for(std::chrono::seconds(6));
    ::kill(launch.pid(), SIGINT);
    ASSERT_EQ(launch.wait(std::chrono::seconds(30)), 0) << launch.output();
    EXPECT_EQ(launch.output().find("lost"), std::string::npos) << launch.output();
    EXPECT_EQ(launch.output().find("dropped"), std::string::npos) << launch.output();
  }
  const recording::McapReader reader(file.string());
  for (const auto& metadata : reader.metadata()) EXPECT_NE(metadata.name, "prehend.losses");
  const auto recording = read_recording(file.string());
  // Every slice is there: the clock's steps are all alike.
  const auto clocks = decode_all<msgs::Clock>(recording, "/clock");
  ASSERT_GT(clocks.size(), 100u);
  for (std::size_t i = 2; i < clocks.size(); ++i) {
    ASSERT_EQ(clocks[i].time() - clocks[i - 1].time(), clocks[1].time() - clocks[0].time()) << i;
  }
  RecordProperty("slices", static_cast<int>(clocks.size()));
}

}  // namespace
}  // namespace prehend::testing
