// What is written is read again, and does the same.

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <random>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/xml_text.h"
#include "tests/robot/formats/arm_urdf.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;
using geometry::InputError;
using geometry::RigidTransform;
using RoundTrip = RobotFiles;

TEST_F(RoundTrip, WhatIsWrittenDoesTheSame) {
  const RobotDescription arm = read("arm.urdf", kUrdfArm);
  for (const char* format : {"urdf", "sdf"}) {
    const RobotDescription again = written_and_read(arm, format);
    const ModelDifference found = difference(arm, again);
    EXPECT_LT(found.place, 1e-9) << format;
    EXPECT_LT(found.turn, 1e-9) << format;
    EXPECT_TRUE(found.others.empty()) << format << ": " << found.others.front();
    EXPECT_TRUE(found.only_first.empty() && found.only_second.empty()) << format;
    const Inertial& inertial = *again.link("upper")->inertial;
    EXPECT_TRUE(inertial.inertia.isApprox(arm.link("upper")->inertial->inertia, 1e-12));
    EXPECT_TRUE(inertial.X_LI.isApprox(arm.link("upper")->inertial->X_LI, 1e-12));
    EXPECT_EQ(again.joint("shoulder")->damping, 0.1);
    EXPECT_EQ(again.link("upper")->collisions[0].name, "hull");
  }
}

TEST_F(RoundTrip, MeshesAreFoundFromWhereItIsWritten) {
  file("here/meshes/a.stl", "solid a\nendsolid a\n");
  RobotDescription robot = read("here/arm.urdf", R"(<robot name="r"><link name="a">
    <visual><geometry><mesh filename="meshes/a.stl"/></geometry></visual>
    <visual><geometry><mesh filename="gone.stl"/></geometry></visual>
    <visual><geometry><mesh filename="package://p/b.stl"/></geometry></visual></link></robot>)");
  fs::create_directories(folder_ / "there/deep");
  move_meshes(robot, folder_ / "here", folder_ / "there/deep");
  EXPECT_EQ(robot.links[0].visuals[0].mesh, "../../here/meshes/a.stl");
  EXPECT_EQ(robot.links[0].visuals[1].mesh, "gone.stl");
  EXPECT_EQ(robot.links[0].visuals[2].mesh, "package://p/b.stl");
}

TEST(RollPitchYaw, OfEveryRotationGivesItBack) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(-4, 4);
  for (int i = 0; i < 1000; ++i) {
    Eigen::Vector3d angles(angle(random), angle(random), angle(random));
    if (i % 4 == 0) angles.y() = (i % 8 == 0 ? 1 : -1) * std::numbers::pi / 2;
    const RigidTransform X = from_roll_pitch_yaw(Eigen::Vector3d::Zero(), angles);
    const RigidTransform again =
        from_roll_pitch_yaw(Eigen::Vector3d::Zero(), roll_pitch_yaw(X.linear()));
    EXPECT_LT((X.linear() - again.linear()).cwiseAbs().maxCoeff(), 1e-9) << angles.transpose();
  }
}

/// All files of others that are read go through formats that are written, and do the same.
TEST_F(RoundTrip, FilesOfOthersComeBackAsTheyWere) {
  if (shared_model("").empty()) GTEST_SKIP() << "no shared models";
  const int count = for_each_shared_robot([&](const fs::path& path, const RobotDescription& robot) {
    for (const char* format : {"urdf", "sdf", "collada"}) {
      RobotDescription again;
      try {
        again = written_and_read(robot, format);
      } catch (const InputError& error) {
        ADD_FAILURE() << path << " as " << format << ": " << error.what();
        continue;
      }
      const ModelDifference found = difference(robot, again, 50);
      EXPECT_LT(std::max(found.place, found.turn), 1e-9) << path << " as " << format;
    }
  });
  EXPECT_GE(count, 50);
}

// The same arm in two formats, by their own authors.
TEST_F(RoundTrip, ThePandaIsThePanda) {
  const fs::path folder = shared_model("urdf/panda_ign");
  if (folder.empty()) GTEST_SKIP() << "no shared models";
  LossReport loss;
  RobotDescription urdf = read_robot(folder / "urdf/panda.urdf", loss);
  const RobotDescription sdf = read_robot(folder / "panda/model.sdf", loss);
  // The SDF says nothing of the coupled finger.
  for (JointDescription& joint : urdf.joints) joint.follows.reset();
  const ModelDifference found = difference(urdf, sdf);
  EXPECT_LT(found.place, 1e-6);
  EXPECT_LT(found.turn, 1e-6);
}

}  // namespace
}  // namespace prehend::robot::formats
