// What a user gets who gives a launch something it cannot use: one clear line and a non-zero exit.

#include <cmath>
#include <cstdint>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/system/launched.h"
#include "tests/system/recorded_box.h"

namespace prehend::testing {
namespace {

using std::chrono::seconds;

class BadInput : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) {
    const auto path = scratch_.path() / name;
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }

  // Runs the launch and expects it to fail with all of `words` in its output.
  void expect_failure(std::vector<std::string> arguments, const std::vector<std::string>& words) {
    arguments.insert(arguments.begin(), "launch");
    arguments.push_back("--log-dir");
    arguments.push_back((scratch_.path() / "log").string());
    const Outcome outcome = run_program("prehend", arguments, seconds(40));
    ASSERT_TRUE(outcome.exit_code) << "still running: " << outcome.output;
    EXPECT_NE(*outcome.exit_code, 0) << outcome.output;
    EXPECT_LT(*outcome.exit_code, 128) << "killed by a signal: " << outcome.output;
    for (const auto& word : words) {
      EXPECT_NE(outcome.output.find(word), std::string::npos) << "'" << word << "' is not in:\n"
                                                              << outcome.output;
    }
  }

  void expect_cloud_failure(const std::string& file, const std::vector<std::string>& words,
                            const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"launch/replay_cloud.yaml", "cloud:=" + file,
                                          "out:=" + (scratch_.path() / "out").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_failure(arguments, words);
  }

  static std::string pcd(const std::string& points, int count) {
    return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " +
           std::to_string(count) + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " +
           std::to_string(count) + "\nDATA ascii\n" + points;
  }

  ScratchFolder scratch_;
};

TEST_F(BadInput, CloudFileThatIsMissing) {
  expect_cloud_failure("no/such/file.pcd", {"no/such/file.pcd"});
}

TEST_F(BadInput, CloudFileOfAnotherKind) {
  expect_cloud_failure(write("picture.pcd", "\x89PNG\r\n\x1a\n not a cloud"), {"picture.pcd"});
}

TEST_F(BadInput, CloudOfOnePoint) {
  expect_cloud_failure(write("one.pcd", pcd("0.1 0.2 0.9\n", 1)), {"point"});
}

TEST_F(BadInput, CloudWithoutAnyValidPoint) {
  expect_cloud_failure(write("nan.pcd", pcd("nan nan nan\nnan nan nan\n", 2)), {"NaN"});
}

TEST_F(BadInput, CloudFileCutShort) {
  std::string binary = pcd("", 1000);
  binary.replace(binary.find("ascii"), 5, "binary");
  expect_cloud_failure(write("short.pcd", binary + std::string(500, 'x')), {"short.pcd"});
}

TEST_F(BadInput, CollinearAndCoplanarPoints) {
  std::string line, plane;
  for (int i = 0; i < 400; ++i) {
    line += std::to_string(i * 1e-3) + " 0.1 0.9\n";
    plane += std::to_string(i % 20 * 2e-3) + " " + std::to_string(i / 20 * 2e-3) + " 0.9\n";
  }
  expect_cloud_failure(write("line.pcd", pcd(line, 400)), {"line"});
  expect_cloud_failure(write("plane.pcd", pcd(plane, 400)), {"plane"});
}

TEST_F(BadInput, TableWithoutObjects) {
  std::string points;
  for (int i = 0; i < 40000; ++i) {
    const double x = (i % 200 - 100) * 4e-3, y = (i / 200 - 100) * 4e-3;
    points += std::to_string(x) + " " + std::to_string(y) + " " +
              std::to_string(1.2 - y * 0.8 + (i * 7 % 11) * 1e-4) + "\n";
  }
  expect_cloud_failure(write("table.pcd", pcd(points, 40000)), {"object"});
}

TEST_F(BadInput, BudgetThatNoSettingKeeps) {
  std::string box;
  int count = 0;
  for (int i = 0; i <= 40; ++i) {
    for (int k = 0; k <= 40; ++k) {
      box += std::to_string(i * 1e-3) + " " + std::to_string(k * 1e-3) + " 0.8\n" +     // front
             std::to_string(i * 1e-3) + " 0 " + std::to_string(0.8 + k * 1e-3) + "\n";  // top
      count += 2;
    }
  }
  // Every object gets the reason, so the launch ends with an answer.
  const auto answer = [&](const std::vector<std::string>& asked) {
    std::vector<std::string> arguments = {"launch",
                                          "launch/replay_cloud.yaml",
                                          "cloud:=" + write("box.pcd", pcd(box, count)),
                                          "out:=" + (scratch_.path() / "out").string(),
                                          "--log-dir",
                                          (scratch_.path() / "log").string()};
    arguments.insert(arguments.end(), asked.begin(), asked.end());
    const Outcome outcome = run_program("prehend", arguments, seconds(40));
    EXPECT_TRUE(outcome.exit_code) << "still running: " << outcome.output;
    return outcome.output;
  };
  EXPECT_NE(answer({"budget:=1e-6"}).find("Allow as much as the fastest one"), std::string::npos);
  EXPECT_NE(answer({"budget:=1", "tolerance:=1"}).find("budget and tolerance are both given"),
            std::string::npos);
}

// It ended with 0, as if something had been lifted, or with 1, as if something had gone wrong.
TEST_F(BadInput, AnObjectTooWideForTheGripperHasAnExitCodeOfItsOwn) {
  const auto out = scratch_.path() / "out";
  const Outcome outcome =
      run_program("prehend",
                  {"launch", "launch/replay_cloud.yaml",
                   "cloud:=" + write("wide.pcd", image_of_a_box({0.16, 0.16, 0.16})),
                   "out:=" + out.string(), "--log-dir", (scratch_.path() / "log").string()},
                  seconds(60));
  EXPECT_EQ(outcome.exit_code, 3) << outcome.output;
  EXPECT_NE(outcome.output.find("not graspable: narrowest width"), std::string::npos)
      << outcome.output;
  std::ifstream in(out / "report.html");
  const std::string page((std::istreambuf_iterator<char>(in)), {});
  EXPECT_NE(page.find("<p class=\"verdict answer\">Not graspable: narrowest width"),
            std::string::npos);
  EXPECT_NE(page.find("Colours of the recorded cloud"), std::string::npos);
}

TEST_F(BadInput, CloudWithoutATable) {
  std::string points;
  std::uint32_t random = 1;
  const auto next = [&random] {
    random = random * 1664525u + 1013904223u;
    return static_cast<double>(random >> 8) / (1 << 24) - 0.5;
  };
  for (int i = 0; i < 20000; ++i) {
    points += std::to_string(2 * next()) + " " + std::to_string(2 * next()) + " " +
              std::to_string(2.5 + 2 * next()) + "\n";
  }
  expect_cloud_failure(write("scatter.pcd", pcd(points, 20000)), {"No table"});
}

TEST_F(BadInput, SplittingByWhatOnlyImagesShow) {
  std::string points;
  for (int i = 0; i < 2000; ++i) {
    points += std::to_string(0.01 * (i % 50)) + " " + std::to_string(0.01 * (i / 50)) + " " +
              std::to_string(0.9 + 0.02 * (i % 7)) + "\n";
  }
  const std::string file = write("scattered.pcd", pcd(points, 2000));
  expect_cloud_failure(file, {"split=wide", "scattered.pcd"}, {"split:=wide"});
}

TEST_F(BadInput, CloudInMillimetres) {
  std::string points;
  for (int i = 0; i < 2000; ++i) {
    points += std::to_string(i % 50 * 10) + " " + std::to_string(i / 50 * 10) + " " +
              std::to_string(900 + i % 7 * 20) + "\n";
  }
  expect_cloud_failure(write("mm.pcd", pcd(points, 2000)), {"millimetres", "scale"});
}

TEST_F(BadInput, CalibrationWithoutBaseline) {
  const std::string calibration =
      write("calibration.yaml", "width: 640\nheight: 480\nfx: 500\nfy: 500\ncx: 320\ncy: 240\n");
  expect_failure(
      {"launch/replay_stereo.yaml", "left:=" + write("l.png", ""), "right:=" + write("r.png", ""),
       "calibration:=" + calibration, "out:=" + (scratch_.path() / "out").string()},
      {"calibration.yaml", "baseline"});
}

TEST_F(BadInput, LaunchFileWithMisspeltNodeKeyOrArgument) {
  expect_failure({write("a.yaml", "nodes:\n  - node: simulatoin\n")}, {"a.yaml:2", "simulation"});
  expect_failure({write("b.yaml", "nodes:\n  - node: simulation\n    parameter: {}\n")},
                 {"b.yaml:3", "parameters"});
  expect_failure({"launch/demo.yaml", "scnee:=x"}, {"scene"});
  expect_failure({"launch/demo.yaml", "scene:=no_such_scene"}, {"no_such_scene"});
}

TEST_F(BadInput, LaunchFilesThatIncludeOneAnother) {
  write("y.yaml", "include:\n  - {file: x.yaml}\n");
  expect_failure({write("x.yaml", "include:\n  - {file: y.yaml}\n")}, {"x.yaml", "y.yaml"});
}

TEST_F(BadInput, RecordingOfAnotherKind) {
  expect_failure({"launch/replay.yaml", "bag:=" + write("notes.mcap", "not a recording"),
                  "out:=" + (scratch_.path() / "out").string()},
                 {"notes.mcap"});
}

TEST_F(BadInput, ASecondNodeOfTheSameNameAndAPortInUse) {
  Launched registry("registry", {"--registry", "tcp://127.0.0.1:*"},
                    scratch_.path() / "registry.txt");
  ASSERT_TRUE(registry.wait_for_output("listens on ", seconds(10)));
  const std::string line = registry.output();
  const auto begin = line.find("tcp://");
  const std::string endpoint = line.substr(begin, line.find_first_of(" \n", begin) - begin);

  const Outcome second_registry = run_program("registry", {"--registry", endpoint}, seconds(10));
  ASSERT_TRUE(second_registry.exit_code) << second_registry.output;
  EXPECT_NE(*second_registry.exit_code, 0);
  EXPECT_NE(second_registry.output.find(endpoint), std::string::npos) << second_registry.output;

  Launched first("shape_completion", {"--registry", endpoint}, scratch_.path() / "first.txt");
  ASSERT_TRUE([&] {
    for (int i = 0; i < 100; ++i) {
      if (run_program("prehend", {"node", "list", "--registry", endpoint}, seconds(10))
              .output.find("shape_completion") != std::string::npos) {
        return true;
      }
    }
    return false;
  }());
  const Outcome second = run_program("shape_completion", {"--registry", endpoint}, seconds(20));
  ASSERT_TRUE(second.exit_code) << second.output;
  EXPECT_NE(*second.exit_code, 0);
  EXPECT_NE(second.output.find("shape_completion"), std::string::npos) << second.output;
  EXPECT_NE(second.output.find(std::to_string(first.pid())), std::string::npos) << second.output;
}

TEST_F(BadInput, LaunchFileWithAParameterNobodyDeclares) {
  const std::string file = write("p.yaml",
                                 "nodes:\n  - node: shape_completion\n    required: true\n"
                                 "    parameters: {orientatoins: 7}\n");
  expect_failure({file}, {"orientatoins", "orientations"});
}

TEST_F(BadInput, AParameterThatWouldDoNothing) {
  for (const std::string other : {"method: block_matching", "eight_directions: true"}) {
    const std::string file = write("p.yaml",
                                   "nodes:\n  - node: stereo_segmentation\n    required: true\n"
                                   "    parameters: {subpixel_window: 9, " +
                                       other + "}\n");
    expect_failure({file}, {"subpixel_window", other.substr(0, other.find(':')), "Leave it away"});
  }
}

TEST_F(BadInput, SplittingByAHandThatNobodyNamed) {
  const std::string file = write("p.yaml",
                                 "nodes:\n  - node: stereo_segmentation\n    required: true\n"
                                 "    parameters: {split: wide}\n");
  expect_failure({file}, {"split is 'wide'", "platform"});
}

}  // namespace
}  // namespace prehend::testing
