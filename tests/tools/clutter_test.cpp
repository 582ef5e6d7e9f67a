// prehend clutter.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "prehend/geometry/mesh_files.h"
#include "prehend/simulation/scene.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class Clutter : public ::testing::Test {
 protected:
  // The command's output and errors; its exit code in exit_code_.
  std::string run(std::vector<std::string> words) {
    words.insert(words.begin(), "clutter");
    ChildProgram program("prehend", words, folder_.path("output"));
    exit_code_ = program.wait(std::chrono::seconds(60)).value_or(-1);
    return program.output();
  }
  fs::path meshes(double scale = 1) {
    const fs::path folder = folder_.path("my meshes");
    fs::create_directories(folder);
    geometry::write_mesh_file(folder / "carton.ply",
                              geometry::make_box(scale * Eigen::Vector3d(0.06, 0.045, 0.1)));
    geometry::write_mesh_file(
        folder / "can.stl",
        geometry::make_revolution({{0.033 * scale, 0}, {0.033 * scale, 0.1 * scale}}, 48));
    return folder;
  }

  ScratchDirectory folder_;
  int exit_code_ = -1;
};

TEST_F(Clutter, WritesScenesWithTruthAndPictures) {
  const fs::path out = folder_.path("heaps");
  const std::string output =
      run({meshes(), "--out", out, "--scenes", "2", "--count", "4", "--touching", "1", "--varied",
           "1", "--center", "0.02", "0", "--size", "0.5", "0.4"});
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output,
              AllOf(HasSubstr("clutter_001.yaml: 4 bodies"), HasSubstr("task:=clear_table")));
  for (const char* name : {"clutter_000", "clutter_001"}) {
    const simulation::Scene scene = simulation::read_scene(out / (std::string(name) + ".yaml"));
    EXPECT_EQ(scene.objects.size(), 4u);
    EXPECT_TRUE(fs::exists(out / (std::string(name) + "_truth.yaml")));
    EXPECT_GT(fs::file_size(out / (std::string(name) + ".png")), 10000u);
  }
  // The simulation takes it by its path.
  ChildProgram launch(
      "prehend", {"launch", "--check", "demo", "scene:=" + (out / "clutter_000.yaml").string()},
      folder_.path("launch"));
  EXPECT_EQ(launch.wait(std::chrono::seconds(30)).value_or(-1), 0) << launch.output();
}

TEST_F(Clutter, SaysWhatIsWrong) {
  const fs::path out = folder_.path("heaps");
  EXPECT_THAT(run({folder_.path("nowhere"), "--out", out}), HasSubstr("nowhere"));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(run({meshes(1000), "--out", out}), HasSubstr("--scale"));
  EXPECT_EQ(exit_code_, 1);
  const std::string folder = meshes();
  EXPECT_THAT(run({folder, "--out", out, "--count", "13"}), HasSubstr("count"));
  EXPECT_EQ(exit_code_, 2);
  EXPECT_THAT(run({folder, "--out", out, "--stacked", "0.7", "--touching", "0.7"}),
              HasSubstr("at most 1"));
  EXPECT_EQ(exit_code_, 1);
  run({folder, "--out", out, "--count", "1"});
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(run({folder, "--out", out, "--count", "1"}), HasSubstr("--overwrite"));
  EXPECT_EQ(exit_code_, 1);
  run({folder, "--out", out, "--count", "1", "--overwrite"});
  EXPECT_EQ(exit_code_, 0);
}

}  // namespace
}  // namespace prehend::testing
