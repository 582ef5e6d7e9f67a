// MJCF, read; and as it is written: MuJoCo's compiler reads it again, and it is the same robot.

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;
using geometry::RigidTransform;
using testing::HasSubstr;

class Mjcf : public RobotFiles {
 protected:
  void SetUp() override {
    for (const auto& format : robot_formats()) {
      if (format->name() == "mjcf") format_ = format.get();
    }
    if (format_ == nullptr) GTEST_SKIP() << "built without MuJoCo";
  }
  RobotDescription written_and_read(const fs::path& file, RobotDescription* given) {
    LossReport loss;
    *given = read_robot(file, loss);
    RobotDescription robot = *given;
    const fs::path from = fs::absolute(file).parent_path();
    write_meshes(take_out_meshes(robot, from, "x", loss, format_->taken_meshes()), folder_);
    std::ofstream(folder_ / "x.mjcf") << format_->write(robot, loss);
    return read_robot(folder_ / "x.mjcf", loss);
  }
  const RobotFormat* format_ = nullptr;
};

void expect_same_dynamics(const RobotDescription& given, const RobotDescription& again) {
  for (const LinkDescription& link : given.links) {
    if (!link.inertial) continue;
    const LinkDescription* other = again.link(link.name);
    ASSERT_TRUE(other && other->inertial) << link.name;
    const auto in_link = [](const Inertial& inertial) -> Eigen::Matrix3d {
      return inertial.X_LI.linear() * inertial.inertia * inertial.X_LI.linear().transpose();
    };
    EXPECT_DOUBLE_EQ(link.inertial->mass, other->inertial->mass) << link.name;
    EXPECT_LT((link.inertial->X_LI.translation() - other->inertial->X_LI.translation()).norm(),
              1e-12);
    const Eigen::Matrix3d I = in_link(*link.inertial);
    EXPECT_LT((I - in_link(*other->inertial)).norm(), 1e-9 * I.norm()) << link.name;
  }
  const ModelDifference found = difference(given, again);
  EXPECT_LT(found.place, 1e-9) << found.where;
  EXPECT_LT(found.turn, 1e-9) << found.where;
  for (const JointDescription& joint : given.joints) {
    if (joint.kind == JointDescription::Kind::kFixed) continue;
    const JointDescription* other = again.joint(joint.name);
    ASSERT_NE(other, nullptr) << joint.name;
    EXPECT_EQ(joint.lower, other->lower) << joint.name;
    EXPECT_EQ(joint.upper, other->upper) << joint.name;
    EXPECT_EQ(joint.follows.has_value(), other->follows.has_value()) << joint.name;
    if (!joint.follows && joint.effort && *joint.effort > 0) {
      EXPECT_EQ(joint.effort, other->effort) << joint.name;
    }
  }
}

TEST_F(Mjcf, IsReadByMuJoCo) {
  const RobotDescription robot = read("r.xml", R"(<mujoco model="m"><worldbody>
    <body name="a" pos="0 0 1"><joint name="j" type="hinge" axis="0 1 0" pos="0 0 0.2" limited="true" range="-90 90" damping="0.3"/>
      <geom type="capsule" size="0.02 0.1" mass="1.5"/>
      <body name="b" pos="0.3 0 0"><joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
        <geom type="box" size="0.01 0.02 0.03"/><site name="s" size="0.01"/></body></body></worldbody>
    <equality><joint joint1="y" joint2="x" polycoef="0.1 2 0 0 0"/></equality>
    <actuator><motor name="m" joint="j" gear="5" forcelimited="true" forcerange="-3 3"/></actuator>
    <sensor><touch site="s"/></sensor></mujoco>)");
  EXPECT_NEAR(*robot.joint("j")->upper, std::numbers::pi / 2, 1e-9);
  EXPECT_EQ(robot.joint("j")->damping, 0.3);
  EXPECT_NEAR(*robot.joint("j")->effort, 15, 1e-12);
  EXPECT_EQ(robot.joint("y")->follows->multiplier(), 2);
  EXPECT_EQ(robot.link("a")->inertial->mass, 1.5);
  EXPECT_EQ(robot.sensors.size(), 1U);
  // About a place 0.2 over its origin, by a right angle: z to x.
  const auto poses = link_poses(robot, {{"j", std::numbers::pi / 2}, {"x", 0.05}});
  EXPECT_TRUE(poses.at("a").translation().isApprox(Eigen::Vector3d(-0.2, 0, 1.2), 1e-9));
  EXPECT_TRUE(poses.at("b").translation().isApprox(Eigen::Vector3d(-0.2, 0.2, 1.2 - 0.35), 1e-9))
      << poses.at("b").translation().transpose();
  EXPECT_THAT(error_of("n.xml", "<mujoco><option nonsense='1'/></mujoco>"), HasSubstr("MuJoCo"));
}

TEST_F(Mjcf, IsTheSameRobotOnceMore) {
  for (const char* file : {"schunk_sdh2.urdf", "barrett_bh8.urdf", "ottobock_sensorhand.urdf",
                           "ur5e.urdf", "robotiq_2f85.urdf", "pa10_7c.urdf"}) {
    RobotDescription given;
    const RobotDescription again = written_and_read(fs::path("config/robots") / file, &given);
    SCOPED_TRACE(file);
    expect_same_dynamics(given, again);
  }
}

TEST_F(Mjcf, MeshesClosedLoopsAndSensorsStay) {
  std::ofstream(folder_ / "given.xml") << R"(<mujoco model="m"><compiler angle="radian"/>
    <worldbody><body name="palm"><geom type="box" size="0.05 0.05 0.02"/>
      <site name="s" pos="0 0 0.02" type="box" size="0.01 0.01 0.001"/>
      <body name="a" pos="0.05 0 0"><joint name="j" type="hinge" axis="0 1 0" limited="true" range="-1 1"
        damping="0.1" frictionloss="0.02"/><geom type="capsule" size="0.01 0.03"/></body>
      <body name="b" pos="-0.05 0 0"><joint name="k" type="slide" axis="1 0 0"/>
        <geom type="cylinder" size="0.01 0.03"/></body></body></worldbody>
    <equality><connect name="loop" body1="a" body2="b" anchor="0 0 0.05"/></equality>
    <contact><exclude body1="a" body2="b"/></contact>
    <actuator><position name="p" joint="j" kp="5"/></actuator>
    <sensor><touch name="t" site="s"/></sensor></mujoco>)";
  RobotDescription given;
  const RobotDescription again = written_and_read(folder_ / "given.xml", &given);
  expect_same_dynamics(given, again);
  ASSERT_EQ(again.loops.size(), 1u);
  EXPECT_LT((again.loops[0].X_FirstLoop.translation() - Eigen::Vector3d(0, 0, 0.05)).norm(), 1e-12);
  EXPECT_EQ(again.disabled_collisions.size(), 1u);
  ASSERT_EQ(again.sensors.size(), 1u);
  EXPECT_EQ(again.sensors[0].link, "palm");
  EXPECT_LT((again.sensors[0].size - given.sensors[0].size).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(again.joint("j")->damping, 0.1);
  EXPECT_DOUBLE_EQ(again.joint("j")->friction, 0.02);
  ASSERT_EQ(again.actuators.size(), 1u);
  EXPECT_EQ(again.actuators[0].control, "position");
}

TEST_F(Mjcf, PolynomialCouplingsStay) {
  std::ofstream(folder_ / "given.xml") << R"(<mujoco model="m"><compiler angle="radian"/>
    <worldbody><body name="palm"><geom type="sphere" size="0.05"/>
      <body name="a"><joint name="j" type="hinge" axis="0 0 1" limited="true" range="-1 1"/><geom type="sphere" size="0.01"/></body>
      <body name="b"><joint name="k" type="hinge" axis="0 0 1"/><geom type="sphere" size="0.01"/></body>
      <body name="c"><joint name="l" type="slide" axis="0 0 1"/><geom type="sphere" size="0.01"/></body>
    </body></worldbody>
    <equality><joint joint1="k" joint2="j" polycoef="0.1 0.5 0.2 -0.3 0.05"/>
      <joint joint1="l" joint2="j" polycoef="0 0.02 0 0 0"/></equality></mujoco>)";
  RobotDescription given;
  const RobotDescription again = written_and_read(folder_ / "given.xml", &given);
  for (const RobotDescription& robot : {given, again}) {
    const Follows& follows = *robot.joint("k")->follows;
    EXPECT_EQ(follows.coefficients, (std::vector<double>{0.1, 0.5, 0.2, -0.3, 0.05}));
    EXPECT_TRUE(robot.joint("l")->follows->is_linear());
    EXPECT_EQ(robot.joint("l")->follows->coefficients.size(), 2U);
    const double q = 0.7;
    const double at = 0.1 + 0.5 * q + 0.2 * q * q - 0.3 * q * q * q + 0.05 * q * q * q * q;
    const auto poses = link_poses(robot, {{"j", q}});
    EXPECT_NEAR(Eigen::AngleAxisd(poses.at("b").linear()).angle(), at, 1e-12);
    EXPECT_NEAR(poses.at("c").translation().z(), 0.02 * q, 1e-15);
  }
  EXPECT_LT(difference(given, again).turn, 1e-12);
  // And a line in its place is another robot.
  RobotDescription line = given;
  for (JointDescription& joint : line.joints) {
    if (joint.name == "k") joint.follows = coupling_line(given, joint).line;
  }
  EXPECT_GT(difference(given, line).turn, 0.05);
}

TEST_F(Mjcf, RobotsOfOthersAreTheSameOnceMore) {
  const char* shared = std::getenv("PREHEND_SHARED_DATA");
  if (shared == nullptr || *shared == '\0')
    GTEST_SKIP() << "set PREHEND_SHARED_DATA to test robots of others";
  const fs::path models = fs::path(shared) / "models";
  for (const char* file :
       {"urdf/allegro_hand_description/allegro_hand_description_right.urdf",
        "sdf/gazebo_models/simple_gripper/model.sdf", "simox/Schunk_SAH/SAH_RightHand.xml",
        "graspit/HumanHand/HumanHand20DOF.xml", "mjcf/shadow_hand/hand/reach.xml",
        "urdf/robotiq_arg85_description/robots/robotiq_arg85_description.URDF"}) {
    RobotDescription given;
    const RobotDescription again = written_and_read(models / file, &given);
    const ModelDifference found = difference(given, again);
    EXPECT_LT(found.place, 1e-9) << file << ": " << found.where;
    EXPECT_LT(found.turn, 1e-9) << file;
  }
}

}  // namespace
}  // namespace prehend::robot::formats
