#include "prehend/simulation/scene.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "prehend/contact/compression_curve.h"
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

TEST_F(SceneFile, AnEngineIsNamedOrTheNearestIsSaid) {
  EXPECT_EQ(read("physics: {engine: native}\n").physics.engine, "native");
  const std::string error = error_of("step: 0.001\nphysics:\n  engine: bulet\n");
  EXPECT_NE(error.find(":3"), std::string::npos) << error;
  EXPECT_NE(error.find("The nearest is 'bullet'"), std::string::npos) << error;
}

TEST_F(SceneFile, StepsAreANumberOrAdaptive) {
  const Scene scene = read("step: 0.002\nphysics: {step: adaptive, tolerance: 2e-6}\n");
  EXPECT_TRUE(scene.physics.adaptive);
  EXPECT_DOUBLE_EQ(scene.physics.tolerance, 2e-6);
  EXPECT_DOUBLE_EQ(scene.step, 0.002);
  EXPECT_FALSE(read("physics: {step: 0.003}\n").physics.adaptive);
  EXPECT_NE(error_of("physics: {step: adaptiv}\n"), "");
  EXPECT_NE(error_of("physics: {step: adaptive, tolerance: -1}\n").find("tolerance"),
            std::string::npos);
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

TEST_F(SceneFile, PhysicsAndHardwareArriveInTheirFields) {
  const Scene scene = read(
      "physics:\n"
      "  integration: second_order\n"
      "  step: 0.002\n"
      "  pads: rigid\n"
      "  law: {normal_law: tabulated, curve: [[0, 0], [0.001, 0.8], [0.003, 4]],\n"
      "        bristle_law: elasto_plastic, return_map: true}\n"
      "  rules: {sleep: false, primitives: false}\n"
      "tactile: {realistic: true, noise: 7, dead: [3, 17], seed: 5, period: 0.02}\n"
      "wrench: {force_noise: 0.1, bias_torque: [0, 0.2, 0]}\n");
  EXPECT_EQ(scene.physics.integration, contact::Integration::kSecondOrder);
  EXPECT_DOUBLE_EQ(scene.step, 0.002);
  EXPECT_TRUE(scene.physics.rules.rigid_pads);
  EXPECT_FALSE(scene.physics.rules.sleep || scene.physics.rules.primitives);
  EXPECT_TRUE(scene.physics.rules.gate_texels && scene.physics.rules.out_of_reach);
  const contact::TexelLaw& law = scene.gripper.pad.law;
  EXPECT_EQ(law.normal_law, contact::NormalLaw::kTabulated);
  ASSERT_NE(law.curve, nullptr);
  EXPECT_DOUBLE_EQ(law.curve->force(0.001), 0.8);
  EXPECT_EQ(law.bristle_law, contact::BristleLaw::kElastoPlastic);
  EXPECT_TRUE(law.return_map);
  EXPECT_DOUBLE_EQ(scene.tactile.sensor.spread, TactileSensorOptions::realistic().spread);
  EXPECT_EQ(scene.tactile.law_of(scene.gripper.pad, 0).memory, contact::FoamMemory::realistic());
  EXPECT_DOUBLE_EQ(scene.tactile.sensor.noise, 7);
  EXPECT_EQ(scene.tactile.sensor.dead, (std::vector<int>{3, 17}));
  EXPECT_EQ(scene.tactile.of_pad(scene.gripper.pad, 0).seed, 5u);
  EXPECT_EQ(scene.tactile.of_pad(scene.gripper.pad, 1).seed, 6u);
  EXPECT_DOUBLE_EQ(scene.tactile.period, 0.02);
  ASSERT_TRUE(scene.wrench.has_value());
  EXPECT_DOUBLE_EQ(scene.wrench->force_noise, 0.1);
  EXPECT_DOUBLE_EQ(scene.wrench->bias[4], 0.2);
}

// The gripper file's figures and the drive's must be of one machine.
TEST_F(SceneFile, ShippedDriveIsThatOfTheLibrary) {
  const Scene scene = read_scene("config/scenes/demo.yaml");
  const SpindleDriveModel shipped = drive_of(scene.gripper, scene.drive), known = pg70_drive();
  EXPECT_NEAR(shipped.force_per_current(), 30, 1e-9);
  EXPECT_NEAR(shipped.reflected_mass(), known.reflected_mass(), 1e-12);
  EXPECT_NEAR(shipped.static_friction, known.static_friction, 1e-12);
  EXPECT_DOUBLE_EQ(shipped.coulomb_friction, known.coulomb_friction);
  EXPECT_DOUBLE_EQ(shipped.peak_current, known.peak_current);
  EXPECT_DOUBLE_EQ(shipped.max_speed, known.max_speed);
  EXPECT_TRUE(scene.tactile.sensor.is_ideal());
}

TEST_F(SceneFile, ASceneGoesBeforeItsGripper) {
  const auto gripper = path_.parent_path() / ("gripper_of_" + path_.filename().string());
  std::ofstream(gripper) << "friction_force: 4\ndrive: {static_friction: 7, rotor_inertia: 1e-6}\n"
                            "tactile: {noise: 2, threshold: 5}\nwrench: {}\n";
  const Scene scene = read("gripper: " + gripper.filename().string() + "\ntactile: {noise: 4}\n");
  const SpindleDriveModel drive = drive_of(scene.gripper, scene.drive);
  EXPECT_DOUBLE_EQ(drive.coulomb_friction, 4);
  EXPECT_DOUBLE_EQ(drive.static_friction, 7);
  EXPECT_DOUBLE_EQ(drive.rotor_inertia, 1e-6);
  EXPECT_DOUBLE_EQ(scene.tactile.sensor.noise, 4);
  EXPECT_EQ(scene.tactile.sensor.threshold, 5);
  EXPECT_TRUE(scene.wrench.has_value());
  std::ofstream(gripper) << "drive: {rotor_mass: 1}\n";
  const std::string error = error_of("gripper: " + gripper.filename().string() + "\n");
  EXPECT_NE(error.find(gripper.string() + ":1: unknown key 'rotor_mass' of drive"),
            std::string::npos)
      << error;
  std::filesystem::remove(gripper);
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
  const auto refused = [&](const std::string& text, const std::string& part) {
    const std::string error = error_of(text);
    EXPECT_NE(error.find(part), std::string::npos) << text << ": " << error;
  };
  refused("physics: {integration: explicit}\n", "first_order, second_order");
  refused("physics: {pads: soft}\n", "texels, rigid");
  refused("physics: {rules: {slep: true}}\n", "'sleep'");
  refused("physics: {rules: {sleep: perhaps}}\n", "neither true nor false");
  refused("step: 0.001\nphysics: {step: 0.002}\n", "beside the scene's own");
  refused("physics: {step: 1}\n", "step must be");
  refused("physics: {most_iterations: 0}\n", "most_iterations");
  refused("physics: {velocity_tolerance: -1}\n", "velocity_tolerance");
  refused("physics: {law: {normal_law: rubber}}\n", "hunt_crossley");
  refused("physics: {law: {normal_law: tabulated}}\n", "curve");
  refused("physics: {law: {curve: [[0, 0], [1]]}}\n", "no pair");
  refused("physics: {law: {curve: [[0, 0], [0.001, -1]]}}\n", "curve");
  refused("physics: {law: {dynamic_friction: 0.9}}\n", "dynamic_friction");
  refused("physics: 3\n", "must be a map");
  refused("tactile: {dead: [84]}\n", "dead");
  refused("tactile: {dead: 3}\n", "no list");
  refused("tactile: {noise: .nan}\n", "noise");
  refused("tactile: {period: 0}\n", "period");
  refused("wrench: {force_range: 0}\n", "force_range");
}

TEST_F(SceneFile, AnObjectLiesWhereItsPoseSays) {
  const Scene scene = read(
      "objects:\n  - {name: a, position: [0.1, 0.2, 0.3], orientation: [0.5, 0.5, 0.5, 0.5]}\n"
      "  - {name: b, x: 0.1, y: 0.2, yaw: 1.2}\n  - {name: c, position: [0.1, 0.2, 0.3]}\n");
  const geometry::RigidTransform X_WA = scene.objects[0].pose(), X_WB = scene.objects[1].pose();
  EXPECT_LT((X_WA * Eigen::Vector3d::UnitX() - Eigen::Vector3d(0.1, 1.2, 0.3)).norm(), 1e-12);
  EXPECT_LT((X_WB * Eigen::Vector3d::UnitX() -
             Eigen::Vector3d(0.1 + std::cos(1.2), 0.2 + std::sin(1.2), 0))
                .norm(),
            1e-12);
  EXPECT_TRUE(scene.objects[2].pose().linear().isIdentity());
  const auto refused = [this](const std::string& keys, const std::string& part) {
    const std::string error = error_of("objects:\n  - {name: a, " + keys + "}\n");
    EXPECT_NE(error.find(":2: "), std::string::npos) << error;
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  refused("position: [0, 0, 0], yaw: 1", "yaw");
  refused("orientation: [1, 0, 0, 0]", "position");
  refused("position: [0, 0, 0], orientation: [1, 0, 0]", "four");
  refused("position: [0, 0, 0], orientation: [a, 0, 0, 0]", "four");
  refused("position: [0, 0, 0], orientation: [1, 1, 0, 0]", "unit");
  refused("position: [0, 0, 0], orientation: [.nan, 0, 0, 0]", "unit");
  refused("position: [0, 0]", "position");
}

// Each shape with numbers of its own, and a pose of either kind.
TEST_F(SceneFile, WhatIsWrittenIsReadAgain) {
  Scene scene;
  for (const char* shape : {"box", "can", "bottle", "mug", "spray_bottle", "ball"}) {
    SceneObject& object = scene.objects.emplace_back();
    const double n = static_cast<double>(scene.objects.size());
    object.name = std::string(shape) + " of " + shape;
    object.shape = shape;
    object.size = {0.05 + 0.001 * n, 0.06, 0.13};
    object.radius = 0.02 + 0.001 * n;
    object.height = 0.1 + 0.01 * n;
    object.wall = 0.003;
    object.mass = 0.1 * n;
    object.friction = 0.4 + 0.05 * n;
    object.x = 0.11 * n;
    object.yaw = -0.3 * n;
    object.texture.pattern = Texture::Pattern::kLabel;
    object.texture.color = {0.1, 0.2, 0.3};
    object.texture.seed = 40 + static_cast<std::uint32_t>(n);
  }
  scene.objects.back().X_WB = geometry::make_transform({0.1, 0.7, -0.5, 0.5}, {0.3, -0.2, 0.11});
  scene.camera.eye = {0.4, 0.1, 0.6};
  scene.camera.noise = 3.5;
  scene.camera.seed = 77;
  scene.light = {{0.1, 0.2, 0.9}, 0.31};
  scene.table.friction = 0.37;
  write_scene(path_, scene, "A test.");
  const Scene read = read_scene(path_);
  ASSERT_EQ(read.objects.size(), scene.objects.size());
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject &a = scene.objects[i], &b = read.objects[i];
    SCOPED_TRACE(a.name);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.shape, b.shape);
    EXPECT_LT((a.pose().matrix() - b.pose().matrix()).norm(), 1e-6);
    const Eigen::AlignedBox3d was = geometry::bounds(object_mesh(a)),
                              is = geometry::bounds(object_mesh(b));
    EXPECT_LT((was.min() - is.min()).norm() + (was.max() - is.max()).norm(), 1e-6);
    EXPECT_NEAR(a.mass, b.mass, 1e-9);
    EXPECT_NEAR(a.friction, b.friction, 1e-9);
    EXPECT_EQ(a.texture.pattern, b.texture.pattern);
    EXPECT_EQ(a.texture.seed, b.texture.seed);
    EXPECT_LT((a.texture.color - b.texture.color).norm(), 1e-6);
  }
  EXPECT_LT((read.camera.eye - scene.camera.eye).norm(), 1e-9);
  EXPECT_EQ(read.camera.noise, 3.5);
  EXPECT_EQ(read.camera.seed, 77u);
  EXPECT_LT((read.light.direction - scene.light.direction).norm(), 1e-9);
  EXPECT_EQ(read.light.ambient, 0.31);
  EXPECT_EQ(read.table.friction, 0.37);
  EXPECT_THROW(write_scene("no_such_folder/scene.yaml", scene, ""), geometry::InputError);
}

TEST_F(SceneFile, ForeignFilesAreRefused) {
  EXPECT_THROW(read_scene("config/scenes/none.yaml"), geometry::InputError);
  EXPECT_FALSE(error_of("- 1\n- 2\n").empty());
  EXPECT_FALSE(error_of("step: [1\n").empty());
}

}  // namespace
}  // namespace prehend::simulation
