// The demo graph as real processes, judged by what was recorded.

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <optional>
#include <thread>
#include <tuple>

#include <gtest/gtest.h>

#include "msgs/graph.pb.h"
#include "msgs/grasp.pb.h"
#include "msgs/sensors.pb.h"
#include "tests/system/carried.h"
#include "tests/system/launched.h"
#include "tests/system/recording.h"

namespace prehend::testing {
namespace {

using std::chrono::seconds;
using Recording = std::map<std::string, std::vector<Recorded>>;

constexpr seconds kRunTimeout{120};

std::vector<std::string> demo_arguments(const std::filesystem::path& out) {
  return {"launch", "launch/demo.yaml", "out:=" + out.string(), "--log-dir",
          (out / "log").string()};
}

// Lifted by 100 mm, moved, put down, and felt by both pads on the way.
void expect_pick_and_place(const Recording& recording) {
  const Carried carried = carried_body(recording);
  EXPECT_GE(carried.raised, 0.1) << carried.name;
  EXPECT_GE(carried.moved, 0.03) << carried.name;
  EXPECT_LT(carried.last_height, 0.01) << carried.name;
  EXPECT_TRUE(carried.touches_table) << carried.name;
  EXPECT_TRUE(carried.both_pads_in_the_air);
  for (const char* topic : {"/tactile/left", "/tactile/right"}) {
    double largest = 0;
    for (const auto& frame : decode_all<msgs::TactileFrame>(recording, topic)) {
      largest = std::max(largest, frame.sum());
    }
    EXPECT_GT(largest, 1.0) << topic;
  }
}

// Every gap in a topic's sequence numbers must have been said by someone. A publisher that was
// started again begins anew at 1.
void expect_no_silent_loss(const Recording& recording) {
  const auto log = decode_all<msgs::graph::LogLine>(recording, "/log");
  for (const auto& [topic, messages] : recording) {
    std::uint32_t previous = 0;
    for (const auto& message : messages) {
      const bool is_gap = previous != 0 && message.sequence > previous + 1;
      previous = message.sequence;
      if (!is_gap) continue;
      const bool said = std::any_of(log.begin(), log.end(), [&](const auto& line) {
        return line.level() >= msgs::graph::WARNING && line.text().find(topic) != std::string::npos;
      });
      EXPECT_TRUE(said) << "a gap before message " << message.sequence << " of " << topic;
    }
  }
}

void expect_report(const std::filesystem::path& file) {
  std::ifstream in(file);
  const std::string html((std::istreambuf_iterator<char>(in)), {});
  for (const char* part :
       {"Left image", "Disparity", "Segmentation", "Completed cloud", "Mesh", "Grasp 1", "left pad",
        "Forces", "Stage times", "class=\"scene\"", "Predicted beside what is true",
        "(carton), upright", "after the lift, to be seen", "prehend launch launch/demo.yaml"}) {
    EXPECT_NE(html.find(part), std::string::npos) << part << " is missing in " << file;
  }
  EXPECT_EQ(html.find("could not be drawn"), std::string::npos);
}

std::vector<msgs::GraspPlan> plans_by_object(const Recording& recording) {
  std::map<std::uint32_t, msgs::GraspPlan> by_id;
  for (auto& plan : decode_all<msgs::GraspPlan>(recording, "/plans")) {
    plan.clear_times();  // seconds differ from run to run
    // So does what would help where nothing can be grasped: it is found out within some of them.
    plan.clear_remedies();
    plan.clear_remedies_in_vain();
    plan.clear_remedies_incomplete();
    plan.set_problem(plan.problem().substr(0, plan.problem().find(". ")));
    by_id[plan.id()] = plan;
  }
  std::vector<msgs::GraspPlan> out;
  for (auto& [id, plan] : by_id) out.push_back(plan);
  return out;
}

TEST(Demo, PicksUpMovesAndPutsDownAndItsRecordingGivesTheSamePlan) {
  const ScratchFolder scratch;
  const auto live_out = scratch.path() / "live";
  std::filesystem::create_directories(live_out);
  {
    Launched demo("prehend", demo_arguments(live_out), scratch.path() / "live.txt");
    const auto exit_code = demo.wait(kRunTimeout);
    ASSERT_EQ(exit_code, 0) << demo.output();
    EXPECT_TRUE(descendants(demo.pid(), "simulation").empty());
    EXPECT_EQ(demo.output().find("predicted mesh"), std::string::npos) << "it is the scene's own";
  }
  const Recording live = read_recording(live_out / "recording.mcap");
  expect_pick_and_place(live);
  expect_no_silent_loss(live);
  expect_report(live_out / "report.html");

  const auto replay_out = scratch.path() / "replay";
  std::filesystem::create_directories(replay_out);
  Launched replay(
      "prehend",
      {"launch", "launch/replay.yaml", "bag:=" + (live_out / "recording.mcap").string(),
       "out:=" + replay_out.string(), "record:=true", "--log-dir", (replay_out / "log").string()},
      scratch.path() / "replay.txt");
  ASSERT_EQ(replay.wait(kRunTimeout), 0) << replay.output();
  EXPECT_NE(replay.output().find("over the table, executed on the predicted mesh. The grasp: "),
            std::string::npos)
      << replay.output();
  const auto live_plans = plans_by_object(live);
  const auto replayed_plans = plans_by_object(read_recording(replay_out / "recording.mcap"));
  ASSERT_FALSE(live_plans.empty());
  ASSERT_EQ(live_plans.size(), replayed_plans.size());
  for (std::size_t i = 0; i < live_plans.size(); ++i) {
    EXPECT_EQ(live_plans[i].SerializeAsString(), replayed_plans[i].SerializeAsString());
  }
}

// Starts the demo and kills one of its nodes when `moment` stands in the output.
class KilledNode : public ::testing::Test {
 protected:
  std::optional<int> run_and_kill(const std::string& node, const std::string& moment) {
    std::filesystem::create_directories(out_);
    Launched demo("prehend", demo_arguments(out_), scratch_.path() / "demo.txt");
    EXPECT_TRUE(demo.wait_for_output(moment, kRunTimeout)) << demo.output();
    // A process has its program's name only once it has got so far, which may be later.
    std::vector<pid_t> victims = descendants(demo.pid(), node);
    for (int i = 0; i < 600 && victims.empty(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      victims = descendants(demo.pid(), node);
    }
    EXPECT_EQ(victims.size(), 1u) << demo.output();
    if (!victims.empty()) kill(victims.front(), SIGKILL);
    const auto exit_code = demo.wait(kRunTimeout);
    output_ = demo.output();
    EXPECT_NE(output_.find("SIGKILL"), std::string::npos) << output_;
    return exit_code;
  }

  ScratchFolder scratch_;
  const std::filesystem::path out_ = scratch_.path() / "out";
  std::string output_;
};

TEST_F(KilledNode, SegmentationBeforeItHasSeenAnything) {
  ASSERT_EQ(run_and_kill("stereo_segmentation", "[simulation] scene"), 0) << output_;
  const Recording recording = read_recording(out_ / "recording.mcap");
  expect_pick_and_place(recording);
  expect_no_silent_loss(recording);
}

// Started again, it segments the latched images once more while the gripper is closing.
TEST_F(KilledNode, SegmentationWhileTheGripperCloses) {
  ASSERT_EQ(run_and_kill("stereo_segmentation", "both pads touch"), 0) << output_;
  const Recording recording = read_recording(out_ / "recording.mcap");
  expect_pick_and_place(recording);
  expect_no_silent_loss(recording);
}

TEST_F(KilledNode, TheRequiredSimulationEndsTheLaunchWithItsReason) {
  const auto exit_code = run_and_kill("simulation", "[shape_completion] object");
  ASSERT_TRUE(exit_code) << output_;
  EXPECT_NE(*exit_code, 0) << output_;
  EXPECT_LT(*exit_code, 128) << output_;
  EXPECT_NE(output_.find("simulation"), std::string::npos);
}

TEST(Demo, InterruptLeavesNoProcessBehind) {
  const ScratchFolder scratch;
  Launched demo("prehend", demo_arguments(scratch.path()), scratch.path() / "demo.txt");
  std::vector<pid_t> children;
  for (int i = 0; i < 600 && children.empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    if (demo.output().find("ready after") == std::string::npos) continue;
    children = descendants(demo.pid(), "grasp_cycle");
  }
  ASSERT_FALSE(children.empty()) << demo.output();
  demo.send_signal(SIGINT);
  EXPECT_TRUE(demo.wait(seconds(20))) << demo.output();
  for (const pid_t child : children) EXPECT_NE(kill(child, 0), 0) << "process " << child;
}

}  // namespace
}  // namespace prehend::testing
