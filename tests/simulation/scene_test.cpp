#include "prehend/simulation/scene.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "prehend/geometry/errors.h"

namespace prehend::simulation {
namespace {

class SceneFile : public ::testing::Test {
 protected:
  SceneFile()
      : path_(std::filesystem::temp_directory_path() /
              ("prehend_scene_" + std::to_string(getpid()) + ".yaml")) {}
  ~SceneFile() override { std::filesystem::remove(path_); }

  Scene read(const std::string& text) {
    std::ofstream(path_) << text;
    return read_scene(path_);
  }
  std::string error_of(const std::string& text) {
    try {
      read(text);
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path path_;
};

TEST_F(SceneFile, ShippedScenesAreRead) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("config/scenes")) {
    SCOPED_TRACE(entry.path().string());
    const Scene scene = read_scene(entry.path());
    EXPECT_EQ(scene.gripper.name, "pg70_dsa");
    EXPECT_DOUBLE_EQ(scene.gripper.pad.law.viscous_friction, 0.1) << "gripper file not read";
    ++count;
  }
  EXPECT_GE(count, 3);
  EXPECT_EQ(read_scene("config/scenes/table_objects.yaml").objects.size(), 6u);
  EXPECT_TRUE(read_scene("config/scenes/replay.yaml").objects.empty());
}

TEST_F(SceneFile, ValuesArriveInTheirFields) {
  const Scene scene = read(
      "step: 0.002\ncamera: {eye: [1, 2, 3], baseline: 0.2}\ntable: {friction: 0.9}\n"
      "carrier: {start: [0, 0.1, 0.2]}\nobjects:\n"
      "  - {name: a, shape: mug, radius: 0.04, mass: 0.7, yaw: 1.5, texture: {seed: 9}}\n");
  EXPECT_DOUBLE_EQ(scene.step, 0.002);
  EXPECT_EQ(scene.camera.eye, Eigen::Vector3d(1, 2, 3));
  EXPECT_DOUBLE_EQ(scene.camera.camera.baseline, 0.2);
  EXPECT_DOUBLE_EQ(scene.table.friction, 0.9);
  EXPECT_EQ(scene.carrier.start, Eigen::Vector3d(0, 0.1, 0.2));
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.objects[0].shape, "mug");
  EXPECT_DOUBLE_EQ(scene.objects[0].mass, 0.7);
  EXPECT_EQ(scene.objects[0].texture.seed, 9u);
}

TEST_F(SceneFile, UnknownKeysNameLineAndNearestKey) {
  std::string error = error_of("step: 0.001\n\ngravitiy: 9.8\n");
  EXPECT_NE(error.find(path_.string() + ":3:"), std::string::npos) << error;
  EXPECT_NE(error.find("'gravity'"), std::string::npos) << error;
  error = error_of("objects:\n  - name: a\n    mas: 1\n");
  EXPECT_NE(error.find(":3:"), std::string::npos) << error;
  EXPECT_NE(error.find("'mass'"), std::string::npos) << error;
}

TEST_F(SceneFile, BadValuesAreRefused) {
  EXPECT_NE(error_of("step: 0\n").find("step"), std::string::npos);
  EXPECT_NE(error_of("step: -.inf\n").find("step"), std::string::npos);
  EXPECT_NE(error_of("camera: {baseline: 0}\n").find("baseline"), std::string::npos);
  EXPECT_NE(error_of("camera: {eye: [0, 0, 1], target: [0, 0, 0]}\n").find("target"),
            std::string::npos);
  EXPECT_NE(error_of("objects: [{name: a, mass: 0}]\n").find("mass"), std::string::npos);
  EXPECT_NE(error_of("objects: [{name: a, mass: heavy}]\n").find("mass"), std::string::npos);
  EXPECT_NE(error_of("objects: [{name: a}, {name: a}]\n").find("'a'"), std::string::npos);
  EXPECT_NE(error_of("objects: [{shape: box}]\n").find("name"), std::string::npos);
  EXPECT_NE(error_of("objects: [{name: a, shape: cube}]\n").find("spray_bottle"),
            std::string::npos);
  EXPECT_NE(error_of("objects: [{name: a, size: [1, -1, 1]}]\n").find("size"), std::string::npos);
  EXPECT_NE(error_of("objects: [{name: a, texture: {pattern: dots}}]\n").find("pattern"),
            std::string::npos);
  EXPECT_NE(error_of("objects: 3\n").find("objects"), std::string::npos);
  EXPECT_NE(error_of("objects: [{name: a, shape: mesh}]\n").find("file"), std::string::npos);
  EXPECT_NE(error_of("gripper: none.yaml\n").find("none.yaml"), std::string::npos);
  EXPECT_NE(error_of("start_opening: 0.2\n").find("start_opening"), std::string::npos);
}

TEST_F(SceneFile, ForeignFilesAreRefused) {
  EXPECT_THROW(read_scene("config/scenes/none.yaml"), geometry::InputError);
  EXPECT_FALSE(error_of("- 1\n- 2\n").empty());
  EXPECT_FALSE(error_of("step: [1\n").empty());
}

}  // namespace
}  // namespace prehend::simulation
