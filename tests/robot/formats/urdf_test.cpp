// URDF: read, and where its links stand.

#include <gmock/gmock.h>

#include "prehend/robot/robot_model.h"
#include "tests/robot/formats/arm_urdf.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using UrdfFiles = RobotFiles;

TEST_F(UrdfFiles, UrdfIsReadWhole) {
  const RobotDescription arm = read("arm.urdf", kUrdfArm);
  EXPECT_EQ(arm.name, "arm");
  ASSERT_EQ(arm.links.size(), 4U);
  ASSERT_TRUE(arm.links[1].inertial);
  EXPECT_EQ(arm.links[1].inertial->mass, 2);
  EXPECT_EQ(arm.links[1].inertial->inertia(0, 2), 0.001);
  EXPECT_EQ(arm.links[1].collisions[0].size.z(), 0.3);
  ASSERT_TRUE(arm.links[1].visuals[0].color);  // by the material's name
  EXPECT_EQ((*arm.links[1].visuals[0].color)[2], 0.6);
  const JointDescription& shoulder = *arm.joint("shoulder");
  EXPECT_EQ(*shoulder.lower, -2);
  EXPECT_EQ(shoulder.friction, 0.2);
  EXPECT_EQ(arm.joint("elbow")->follows->offset(), 0.03);
  // All but Gazebo's part was kept.
  ASSERT_EQ(loss_.entries().size(), 1U) << loss_.text();
  EXPECT_EQ(loss_.entries()[0].what, "robot/gazebo");
  EXPECT_THAT(loss_.entries()[0].place, HasSubstr("arm.urdf:20"));
}

// urdfdom's own model, and this one's kinematics.
TEST_F(UrdfFiles, UrdfStandsWhereUrdfdomHasIt) {
  const RobotDescription arm = read("arm.urdf", kUrdfArm);
  const RobotModel oracle = read_urdf(folder_ / "arm.urdf");
  std::map<std::string, RigidTransform> poses{{"base", RigidTransform::Identity()}};
  const double q = 0.7;
  for (const Joint& joint : oracle.joints) {
    const double at = joint.mimic ? joint.mimic->multiplier * q + joint.mimic->offset : q;
    poses[oracle.links[static_cast<std::size_t>(joint.child)].name] =
        poses.at(oracle.links[static_cast<std::size_t>(joint.parent)].name) * joint.pose_at(at);
  }
  for (const auto& [name, X] : link_poses(arm, {{"shoulder", q}})) {
    EXPECT_TRUE(X.isApprox(poses.at(name), 1e-12)) << name;
  }
}

TEST_F(UrdfFiles, UnknownPartsAreSaidWithTheirPlace) {
  std::string text = kUrdfArm;
  text.replace(text.find("<link name=\"base\"/>"), 19,
               "<link name=\"base\" colour=\"red\"><soul weight=\"21\"><deep/></soul></link>");
  read("arm.urdf", text);
  std::vector<std::string> lost;
  for (const auto& entry : loss_.entries()) lost.push_back(entry.what);
  EXPECT_THAT(lost, AllOf(Contains("robot/link/@colour"), Contains("robot/link/soul")));
  EXPECT_THAT(lost, testing::Not(Contains("robot/link/soul/deep")));  // it is in what was dropped
  EXPECT_THAT(loss_.text(), HasSubstr("3 dropped"));
}

}  // namespace
}  // namespace prehend::robot::formats
