// What a user gets who gives a launch something it cannot use: one clear line and a non-zero exit.

#include <fstream>

#include <gtest/gtest.h>

#include "tests/system/launched.h"

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
      EXPECT_NE(outcome.output.find(word), std::string::npos)
          << "'" << word << "' is not in:\n" << outcome.output;
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
  expect_failure({"launch/replay_stereo.yaml", "left:=l.png", "right:=r.png",
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

TEST_F(BadInput, LaunchFileWithAParameterNobodyDeclares) {
  const std::string file = write("p.yaml",
                                 "nodes:\n  - node: shape_completion\n    required: true\n"
                                 "    parameters: {orientatoins: 7}\n");
  expect_failure({file}, {"orientatoins", "orientations"});
}

}  // namespace
}  // namespace prehend::testing
