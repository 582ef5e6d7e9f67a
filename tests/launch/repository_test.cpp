// The launch files that come with the repository.

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/launch/supervision_fixture.h"

namespace prehend::testing {
namespace {

using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(LaunchFilesOfTheRepository, AreAllCorrect) {
  const ScratchDirectory scratch;
  ChildProgram check("prehend", {"launch", "--check", "launch"}, scratch.path("output.txt"));
  EXPECT_EQ(check.wait(seconds(100)), 0) << check.output();
  const auto is_launch_file = [](const auto& entry) { return entry.path().extension() == ".yaml"; };
  const auto files =
      std::count_if(std::filesystem::directory_iterator("launch"), {}, is_launch_file);
  ASSERT_GE(files, 6);
  const std::string output = check.output();
  std::size_t correct = 0;
  for (auto at = output.find(": correct, "); at != std::string::npos;
       at = output.find(": correct, ", at + 1)) {
    ++correct;
  }
  EXPECT_EQ(correct, static_cast<std::size_t>(files)) << output;
  EXPECT_EQ(output.find("not checked: it does not"), std::string::npos) << output;
}

TEST(LaunchFilesOfTheRepository, AreCheckedWithThePredictionComposed) {
  const ScratchDirectory scratch;
  ChildProgram check("prehend", {"launch", "--check", "launch/prediction.yaml", "composed:=true"},
                     scratch.path("output.txt"));
  EXPECT_EQ(check.wait(seconds(30)), 0) << check.output();
}

// `generators` is a list with choices: its default came over as a text, so that every form of it
// was refused, "[circles]" as well.
TEST(LaunchFilesOfTheRepository, ListsAreCheckedAgainstWhatTheProgramTakes) {
  const ScratchDirectory scratch;
  int calls = 0;
  const auto check = [&](const std::string& parameters,
                         const std::string& node = "grasp_planning") {
    scratch.write("a.yaml", "nodes: [{node: " + node + ", parameters: {" + parameters + "}}]\n");
    ChildProgram program("prehend", {"launch", "--check", scratch.path("a.yaml")},
                         scratch.path(std::to_string(++calls)));
    const bool is_right = program.wait(seconds(30)) == 0;
    return (is_right ? "right: " : "wrong: ") + program.output();
  };
  for (const char* right : {"generators: [circles]", "generators: \"[segments, boxes]\"",
                            "generators: [circles, segments, boxes, antipodal, medial_axis]"}) {
    EXPECT_THAT(check(right), HasSubstr("right: ")) << right;
  }
  EXPECT_THAT(check("mounting: [0, 0, -0.05, 0, 0, 1.5]", "ft300"), HasSubstr("right: "));
  EXPECT_THAT(check("generators: [circles, segment]"),
              AllOf(HasSubstr("wrong: "), HasSubstr("must be one of: antipodal, boxes"),
                    HasSubstr("(item 2)")));
  EXPECT_THAT(check("generators: circles"), HasSubstr("must be a list between brackets"));
  EXPECT_THAT(check("mounting: [0, up, 0, 0, 0, 0]", "ft300"), HasSubstr("item 2 is none"));
  EXPECT_THAT(check("density: [1, 2]"), HasSubstr("of type number"));
}

// What the resolved graph of a launch file says of its nodes.
class TouchOfLaunchFiles : public ::testing::Test {
 protected:
  // The exit code is 0 where the arguments apply.
  std::string dry_run(std::vector<std::string> words, int exit_code = 0) {
    words.insert(words.begin(), {"launch", "--dry-run"});
    ChildProgram program("prehend", words, scratch_.path(std::to_string(++calls_)));
    EXPECT_EQ(program.wait(seconds(30)), exit_code) << program.output();
    return program.output();
  }

  // The lines of one node.
  static std::string of_node(const std::string& graph, const std::string& node) {
    const std::size_t begin = graph.find("- node: " + node);
    EXPECT_NE(begin, std::string::npos) << node;
    return begin == std::string::npos
               ? ""
               : graph.substr(begin, graph.find("- node: ", begin + 1) - begin);
  }

  static void expect_world(const std::string& graph, const std::string& file) {
    EXPECT_THAT(of_node(graph, "simulation"),
                AllOf(HasSubstr("\n      tolerance: 0.31\n"), HasSubstr("\n      budget: 0\n")))
        << file;
  }
  static void expect_prediction(const std::string& graph, const std::string& file) {
    EXPECT_THAT(of_node(graph, "grasp_planning"),
                AllOf(HasSubstr("touch_budget: 0.32\n"), HasSubstr("touch_tolerance: 0\n")))
        << file;
  }

 private:
  ScratchDirectory scratch_;
  int calls_ = 0;
};

// Refused before anything starts, and by --check.
TEST_F(TouchOfLaunchFiles, IsChosenByOneOfBoth) {
  for (const char* file : {"launch/demo.yaml", "launch/simulated_robot.yaml"}) {
    EXPECT_THAT(dry_run({file, "touch_budget:=1", "touch_tolerance:=0.1"}, 1),
                HasSubstr("touch_budget and touch_tolerance are both given"));
  }
  EXPECT_THAT(dry_run({"launch/demo.yaml", "platform:=kr5_sdh", "predicted_touch_budget:=1",
                       "predicted_touch_tolerance:=0.1"},
                      1),
              HasSubstr("predicted_touch_budget and predicted_touch_tolerance are both given"));
  EXPECT_THAT(dry_run({"launch/demo.yaml", "budget:=1", "tolerance:=0.1"}, 1),
              HasSubstr("budget and tolerance are both given"));
}

// Both reach the world; what predicts touch is asked apart.
TEST_F(TouchOfLaunchFiles, IsChosenForTheWorldAndForItsPrediction) {
  const std::vector<std::vector<std::string>> files{
      {"launch/demo.yaml", "platform:=kr5_sdh"},
      {"launch/kth.yaml"},
      {"launch/uji.yaml"},
      {"launch/bringup.yaml", "platform:=kr5_sdh", "cycle:=true"},
      {"launch/replay.yaml", "bag:=a.mcap", "platform:=kr5_sdh"},
      {"launch/replay_cloud.yaml", "cloud:=a.pcd", "platform:=kr5_sdh"},
      {"launch/replay_stereo.yaml", "left:=l.png", "right:=r.png", "calibration:=K.txt",
       "platform:=kr5_sdh"},
      {"launch/replay_views.yaml", "first:=a.pcd", "second:=b.pcd", "platform:=kr5_sdh"}};
  for (std::vector<std::string> words : files) {
    words.insert(words.end(), {"touch_tolerance:=0.31", "predicted_touch_budget:=0.32"});
    const std::string graph = dry_run(words);
    expect_world(graph, words[0]);
    expect_prediction(graph, words[0]);
  }
}

// One budget, or one tolerance, for every stage from images to grasps.
TEST_F(TouchOfLaunchFiles, OneBudgetReachesAllStages) {
  const std::vector<std::vector<std::string>> files{
      {"launch/demo.yaml"},
      {"launch/demo.yaml", "platform:=kr5_sdh"},
      {"launch/uji.yaml"},
      {"launch/hil.yaml"},
      {"launch/bringup.yaml", "platform:=kr5_sdh", "cycle:=true"},
      {"launch/replay.yaml", "bag:=a.mcap"},
      {"launch/replay_cloud.yaml", "cloud:=a.pcd"},
      {"launch/replay_stereo.yaml", "left:=l.png", "right:=r.png", "calibration:=K.txt"},
      {"launch/replay_views.yaml", "first:=a.pcd", "second:=b.pcd"},
      {"launch/replay_views.yaml", "platform:=kr5_sdh", "first:=a.pcd", "second:=b.pcd"}};
  for (std::vector<std::string> words : files) {
    const bool has_gripper = words.size() == 1 || words[1].rfind("platform", 0) != 0;
    const bool is_stage = has_gripper && words[0] != "launch/uji.yaml";
    const bool of_cloud =
        words[0] == "launch/replay_cloud.yaml" || words[0] == "launch/replay_views.yaml";
    const std::string front =
        std::string("/chain") + (of_cloud ? "_cloud" : "") + (is_stage ? "" : "_hand") + ".yaml\n";
    for (const char* argument : {"budget", "tolerance"}) {
      std::vector<std::string> asked = words;
      asked.push_back(std::string(argument) + ":=0.75");
      const std::string graph = dry_run(asked);
      for (const char* node : {of_cloud ? "cloud_source" : "stereo_segmentation",
                               "shape_completion", "poisson_meshing", "grasp_planning"}) {
        EXPECT_THAT(of_node(graph, node),
                    AllOf(HasSubstr(std::string(argument) + ": 0.75\n"), HasSubstr(front)))
            << words[0] << " " << node;
      }
    }
    // A task may have one: every stage knows the task and the front.
    std::vector<std::string> of_task = words;
    of_task.emplace_back("task:=work_cycle");
    const std::string graph = dry_run(of_task);
    for (const char* node : {of_cloud ? "cloud_source" : "stereo_segmentation", "shape_completion",
                             "poisson_meshing", "grasp_planning"}) {
      EXPECT_THAT(of_node(graph, node), AllOf(HasSubstr("task: work_cycle\n"), HasSubstr(front)))
          << words[0] << " " << node;
    }
  }
  EXPECT_THAT(of_node(dry_run({"launch/prediction.yaml", "plan_budget:=1"}), "grasp_planning"),
              HasSubstr("front: \"\"\n"));
  EXPECT_THAT(dry_run({"launch/prediction.yaml", "budget:=1", "plan_budget:=1"}, 1),
              HasSubstr("leave plan_budget away"));
  EXPECT_THAT(dry_run({"launch/prediction.yaml", "input:=clod"}, 1),
              HasSubstr("images or cloud, and not clod"));
}

// The paper's candidates were not measured in chains: the two are not had together.
TEST_F(TouchOfLaunchFiles, OneBudgetIsNotForThePapersCandidates) {
  EXPECT_THAT(dry_run({"launch/kth.yaml", "budget:=2"}, 1),
              AllOf(HasSubstr("launch/kth.yaml:"), HasSubstr("[segments]"),
                    HasSubstr("give generators:=[] too")));
  const std::string graph = dry_run({"launch/kth.yaml", "tolerance:=0.003", "generators:=[]"});
  for (const char* node :
       {"stereo_segmentation", "shape_completion", "poisson_meshing", "grasp_planning"}) {
    EXPECT_THAT(of_node(graph, node),
                AllOf(HasSubstr("tolerance: 0.003\n"), HasSubstr("/chain_hand.yaml\n")))
        << node;
  }
  const std::string camera = dry_run({"launch/emulated_camera.yaml", "cycle:=true", "budget:=2"});
  EXPECT_THAT(of_node(camera, "stereo_segmentation"), HasSubstr("budget: 2\n"));
  EXPECT_THAT(dry_run({"launch/emulated_camera.yaml", "budget:=2"}, 1), HasSubstr("budget"));
}

// The grasps of the PG70, the only hand of hil.yaml, are planned by what its pads feel: there is
// nothing to be chosen for them.
TEST_F(TouchOfLaunchFiles, IsChosenForTheWorldBehindWires) {
  expect_world(dry_run({"launch/hil.yaml", "touch_tolerance:=0.31"}), "hil.yaml");
  EXPECT_THAT(dry_run({"launch/hil.yaml", "predicted_touch_budget:=0.32"}, 1),
              HasSubstr("predicted_touch_budget"));
}

// A world runs behind bringup.yaml while one device is simulated, a planner with cycle:=true.
TEST_F(TouchOfLaunchFiles, IsRefusedWhereNothingIsSimulatedOrPlanned) {
  const std::vector<std::vector<std::string>> devices{{"gripper:=pg70"},
                                                      {"tactile:=dsa"},
                                                      {"wrench:=ft300"},
                                                      {"gripper:=pg70", "tactile:=dsa"},
                                                      {"gripper:=pg70", "wrench:=ft300"},
                                                      {"tactile:=dsa", "wrench:=ft300"}};
  for (std::vector<std::string> words : devices) {
    words.insert(words.begin(), {"launch/bringup.yaml", "touch_tolerance:=0.31"});
    expect_world(dry_run(words), words[2]);
  }
  const std::vector<std::string> real{"launch/bringup.yaml", "gripper:=pg70", "tactile:=dsa",
                                      "wrench:=ft300"};
  for (const char* argument : {"touch_tolerance:=0.31", "predicted_touch_budget:=0.32"}) {
    std::vector<std::string> words = real;
    words.emplace_back(argument);
    const std::string name = words.back().substr(0, words.back().find(':'));
    EXPECT_THAT(dry_run(words, 1), HasSubstr(name));
  }
}

// With all devices real nothing is simulated, so the launch says what is missing.
TEST(LaunchFilesOfTheRepository, BringupTakesCalibrationsAndSaysWhatIsMissing) {
  const ScratchDirectory scratch;
  const std::vector<std::string> real{"gripper:=pg70", "tactile:=dsa", "wrench:=ft300"};
  std::vector<std::string> words{"launch", "--dry-run", "launch/bringup.yaml"};
  words.insert(words.end(), real.begin(), real.end());
  for (const char* argument :
       {"matrices:=[1, 0]", "flip_rows:=[left]", "newton_per_count:=0.001", "current_by:=grip",
        "mounting:=[0, 0, -0.05, 0, 0, 1.5]", "inverted:=true", "opening_per_position:=2.0"}) {
    words.push_back(argument);
  }
  ChildProgram bringup("prehend", words, scratch.path("bringup.txt"));
  EXPECT_EQ(bringup.wait(seconds(30)), 0) << bringup.output();
  for (const char* part : {"no camera is named", "[1, 0]", "[left]", "0.001", "grip", "-0.05",
                           "inverted: true", "opening_per_position: 2"}) {
    EXPECT_THAT(bringup.output(), HasSubstr(part));
  }
  EXPECT_THAT(bringup.output(), ::testing::Not(HasSubstr("grasp_cycle")));
  words[1] = "--check";
  words.push_back("cycle:=true");
  ChildProgram check("prehend", words, scratch.path("check.txt"));
  EXPECT_EQ(check.wait(seconds(60)), 0) << check.output();
  words[1] = "--dry-run";
  ChildProgram cycle("prehend", words, scratch.path("cycle.txt"));
  EXPECT_EQ(cycle.wait(seconds(30)), 0) << cycle.output();
  EXPECT_THAT(cycle.output(), HasSubstr("grasp_cycle"));
  EXPECT_THAT(cycle.output(), HasSubstr("shape_completion"));
}

// A real camera publishes where the simulated one did; what is not its own is refused.
TEST(LaunchFilesOfTheRepository, BringupTakesCameras) {
  const ScratchDirectory scratch;
  int calls = 0;
  const auto dry_run = [&](std::vector<std::string> words, int exit_code) {
    words.insert(words.begin(), {"launch", "--dry-run", "launch/bringup.yaml"});
    ChildProgram program("prehend", words, scratch.path(std::to_string(calls++) + ".txt"));
    EXPECT_EQ(program.wait(seconds(30)), exit_code) << program.output();
    return program.output();
  };
  const std::string depth =
      dry_run({"camera:=openni", "cycle:=true", "camera_pose:=[0, 0, 1, 0, 1, 0, 0]"}, 0);
  for (const char* part : {"node: depth_camera", "/camera/*: /unused/camera/*", "input: depth",
                           "[0, 0, 1, 0, 1, 0, 0]"}) {
    EXPECT_THAT(depth, HasSubstr(part));
  }
  const std::string pair =
      dry_run({"camera:=stereo", "camera_calibration:=K", "right_camera_source:=/dev/video4"}, 0);
  EXPECT_THAT(pair, HasSubstr("kind: stereo"));
  EXPECT_THAT(pair, HasSubstr("right_source: /dev/video4"));
  EXPECT_THAT(dry_run({}, 0), ::testing::Not(HasSubstr("/unused/camera")));
  EXPECT_THAT(dry_run({"camera:=openni", "cycle:=true"}, 1), HasSubstr("camera_pose"));
  EXPECT_THAT(dry_run({"camera:=side_by_side"}, 1), HasSubstr("camera_calibration"));
  EXPECT_THAT(dry_run({"camera:=openni", "right_camera_source:=a"}, 1), HasSubstr("no effect"));
  EXPECT_THAT(dry_run({"camera:=openi"}, 1), HasSubstr("did you mean \"openni\""));
}

// A BarrettHand has its own pads; what it cannot be is refused by name.
TEST(LaunchFilesOfTheRepository, BringupAndHilTakeABarrettHand) {
  const ScratchDirectory scratch;
  int calls = 0;
  const auto dry_run = [&](std::vector<std::string> words, int exit_code) {
    words.insert(words.begin(), {"launch", "--dry-run"});
    ChildProgram program("prehend", words, scratch.path(std::to_string(calls++) + ".txt"));
    EXPECT_EQ(program.wait(seconds(30)), exit_code) << program.output();
    return program.output();
  };
  const std::string bringup = "launch/bringup.yaml", of_pa10 = "platform:=pa10_barrett";
  const std::string hand =
      dry_run({bringup, of_pa10, "hand:=barrett", "barrett:=can3", "cycle:=true"}, 0);
  for (const char* part :
       {"node: barrett", "can: can3", "initialise: asked", "/hand/*: /unused/hand/*",
        "/tactile/*: /unused/tactile/*", "/joint_states: /unused/joint_states",
        "gripper_driver: barrett", "clock: simulated"}) {
    EXPECT_THAT(hand, HasSubstr(part));
  }
  EXPECT_THAT(dry_run({bringup, of_pa10, "hand:=barrett", "wrench:=ft300"}, 0),
              ::testing::Not(HasSubstr("node: simulation")))
      << "its pads count as real";
  for (const char* platform : {"stage_pg70", "kr5_pg70", "kr5_sdh"}) {
    for (const char* file : {"launch/bringup.yaml", "launch/hil.yaml"}) {
      EXPECT_THAT(dry_run({file, std::string("platform:=") + platform, "hand:=barrett"}, 1),
                  HasSubstr("platform:=pa10_barrett"));
    }
  }
  EXPECT_THAT(dry_run({bringup, of_pa10, "hand:=barrett", "tactile:=dsa"}, 1),
              HasSubstr("leave tactile:=dsa away"));
  EXPECT_THAT(dry_run({bringup, of_pa10, "hand:=barrett", "gripper:=pg70"}, 1),
              HasSubstr("a robot has one hand"));
  EXPECT_THAT(dry_run({bringup, of_pa10, "barrett:=can3"}, 1), HasSubstr("no effect"));
  const std::string all = dry_run({"launch/hil.yaml", of_pa10}, 0);
  for (const char* part : {"node: barrett_emulator", "can: slcan:/tmp/prehend_hil_barrett",
                           "initialise: at_start", "gripper_driver: barrett",
                           "/tactile/*: /world/tactile/*", "other_joints: /world/joint_states"}) {
    EXPECT_THAT(all, HasSubstr(part));
  }
  EXPECT_THAT(dry_run({"launch/hil.yaml", of_pa10, "hand:=sim"}, 0),
              ::testing::Not(HasSubstr("barrett_emulator")));
}

// A BH8-262 is the same hand on a serial line; what is another model's is refused by name.
TEST(LaunchFilesOfTheRepository, BringupAndHilTakeABarrettHandByItsSerialLine) {
  const ScratchDirectory scratch;
  int calls = 0;
  const auto dry_run = [&](std::vector<std::string> words, int exit_code) {
    words.insert(words.begin(), {"launch", "--dry-run"});
    ChildProgram program("prehend", words, scratch.path(std::to_string(calls++) + ".txt"));
    EXPECT_EQ(program.wait(seconds(30)), exit_code) << program.output();
    return program.output();
  };
  const auto bringup = [&](std::vector<std::string> more, int exit_code) {
    more.insert(more.begin(), {"launch/bringup.yaml", "platform:=pa10_barrett", "hand:=barrett",
                               "barrett_model:=bh8_262"});
    return dry_run(more, exit_code);
  };
  const std::string line = "barrett:=/dev/ttyUSB3";
  const std::string hand = bringup({line, "barrett_fast_baud:=38400"}, 0);
  for (const char* part : {"node: barrett", "model: bh8_262", "line: /dev/ttyUSB3",
                           "fast_baud: 38400", "/tactile/*: /unused/tactile/*"}) {
    EXPECT_THAT(hand, HasSubstr(part));
  }
  EXPECT_THAT(hand, ::testing::Not(HasSubstr("can: ")));
  EXPECT_THAT(bringup({}, 1), HasSubstr("name it, barrett:=/dev/ttyUSB2"));
  EXPECT_THAT(bringup({line, "barrett_initialise:=done"}, 1), HasSubstr("tells by itself"));
  EXPECT_THAT(bringup({line, "tactile:=dsa"}, 1), HasSubstr("a BH8-262 has none"));
  EXPECT_THAT(bringup({line, "most_torque:=900"}, 1), HasSubstr("no effect"));
  EXPECT_THAT(bringup({line, "barrett_baud:=115200"}, 1), HasSubstr("38400"));
  const std::vector<std::string> of_280{"launch/bringup.yaml", "platform:=pa10_barrett",
                                        "hand:=barrett", "strain_range:=50"};
  EXPECT_THAT(dry_run(of_280, 1), HasSubstr("no effect"));
  const std::string all =
      dry_run({"launch/hil.yaml", "platform:=pa10_barrett", "barrett_model:=bh8_262"}, 0);
  for (const char* part : {"node: barrett_serial_emulator", "line: /tmp/prehend_hil_barrett",
                           "initialise: at_start", "gripper_driver: barrett"}) {
    EXPECT_THAT(all, HasSubstr(part));
  }
}

}  // namespace
}  // namespace prehend::testing
