// Simox's robots.

#include <gmock/gmock.h>

#include <numbers>

#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using testing::HasSubstr;
using SimoxFiles = RobotFiles;

const std::string kSimox = R"(<Robot Type="Finger" RootNode="Palm">
  <RobotNode name="Tip"><Transform><Translation X="0" Y="0" Z="30" units="mm"/><rpy roll="0" pitch="90" yaw="0" units="degree"/></Transform></RobotNode>
  <RobotNode name="Palm"><Physics><Mass value="800" unit="g"/></Physics><Child name="Knuckle"/></RobotNode>
  <RobotNode name="Knuckle"><Transform><DH a="40" d="5" theta="30" alpha="-90" unitsangle="degree" unitslength="mm"/></Transform>
    <Joint type="revolute" offset="0.1"><Axis x="0" y="1" z="0"/><Limits unit="degree" lo="-10" hi="80"/>
      <PropagateJointValue name="Middle" factor="0.5"/></Joint><Child name="Middle"/></RobotNode>
  <RobotNode name="Middle"><Transform><Translation x="0.05" y="0" z="0" units="m"/></Transform>
    <Joint type="revolute"/><Visualization><File type="Inventor">m.iv</File><UseAsCollisionModel/></Visualization><Child name="Tip"/></RobotNode>
  <Endeffector name="Hand" base="Palm" tcp="Tip"/>
</Robot>)";

TEST_F(SimoxFiles, SimoxNodesArePosesWithAJoint) {
  const RobotDescription hand = read("finger.xml", kSimox);
  EXPECT_EQ(hand.links.front().name, "Palm");
  EXPECT_NEAR(hand.link("Palm")->inertial->mass, 0.8, 1e-15);
  EXPECT_EQ(hand.joint("Middle")->follows->joint, "Knuckle");  // the leader names it
  EXPECT_EQ(hand.link("Middle")->collisions.size(), 1U);
  ASSERT_EQ(hand.manipulators.size(), 1U);
  EXPECT_EQ(hand.manipulators[0].base, "Palm");
  EXPECT_EQ(hand.manipulators[0].tip, "Tip");
  constexpr double kDegree = std::numbers::pi / 180;
  const double q = 0.3;
  RigidTransform X = RigidTransform::Identity();
  X.rotate(Eigen::AngleAxisd(30 * kDegree, Eigen::Vector3d::UnitZ()));
  X.translate(Eigen::Vector3d(0.04, 0, 0.005));
  X.rotate(Eigen::AngleAxisd(-90 * kDegree, Eigen::Vector3d::UnitX()));
  X.rotate(Eigen::AngleAxisd(q + 0.1, Eigen::Vector3d::UnitY()));
  X.translate(Eigen::Vector3d(0.05, 0, 0));
  X.rotate(Eigen::AngleAxisd(0.5 * q, Eigen::Vector3d::UnitZ()));
  X.translate(Eigen::Vector3d(0, 0, 0.03));
  X.rotate(Eigen::AngleAxisd(90 * kDegree, Eigen::Vector3d::UnitY()));
  EXPECT_TRUE(link_poses(hand, {{"Knuckle", q}}).at("Tip").isApprox(X, 1e-12));
  EXPECT_THAT(error_of("twice.xml",
                       "<Robot RootNode='a'><RobotNode name='a'><Child name='b'/>"
                       "<Child name='b'/></RobotNode><RobotNode name='b'/></Robot>"),
              HasSubstr("twice"));
}

}  // namespace
}  // namespace prehend::robot::formats
