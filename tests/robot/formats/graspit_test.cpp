// GraspIt!'s hands.

#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>

#include "prehend/robot/formats/model_check.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using testing::AllOf;
using testing::HasSubstr;
using GraspItFiles = RobotFiles;

const std::string kHand = R"(<robot type="Hand"><palm>palm.xml</palm>
  <dof type="b"><defaultVelocity>1</defaultVelocity><maxEffort>2.5e9</maxEffort><Kp>1</Kp><Kd>1</Kd>
    <draggerScale>1</draggerScale><breakAwayTorque>0.5</breakAwayTorque></dof>
  <dof type="r"><defaultVelocity>1</defaultVelocity><maxEffort>1e9</maxEffort><Kp>1</Kp><Kd>1</Kd><draggerScale>1</draggerScale></dof>
  <chain><transform><translation>10 20 30</translation><rotation>90 x</rotation></transform>
    <joint type="Revolute"><theta>d0+15</theta><d>5</d><a>50</a><alpha>-90</alpha><minValue>0</minValue><maxValue>140</maxValue></joint>
    <joint type="Revolute"><theta>d0*0.333+40</theta><d>0</d><a>40</a><alpha>0</alpha><minValue>0</minValue><maxValue>48</maxValue></joint>
    <joint type="Prismatic"><theta>30</theta><d>d1-2</d><a>7</a><alpha>10</alpha><minValue>0</minValue><maxValue>20</maxValue></joint>
    <link dynamicJointType="Revolute">one.xml</link><link dynamicJointType="Revolute">two.xml</link>
    <link dynamicJointType="Prismatic">gone.xml</link>
    <filter type="grid" params="0,0,0,2,4,6">1</filter></chain></robot>)";

const std::string kBody =
    R"(<root><geometryFile type="Inventor">palm.iv</geometryFile><mass>250</mass>
  <cog>1 2 3</cog><inertia_matrix>100 0 0 0 200 0 0 0 250</inertia_matrix></root>)";

TEST_F(GraspItFiles, GraspItHandsAreChainsByDenavitAndHartenberg) {
  for (const char* body : {"iv/palm.xml", "iv/one.xml", "iv/two.xml"}) file(body, kBody);
  const RobotDescription hand = read("hand.xml", kHand);
  ASSERT_EQ(hand.links.size(), 4U);
  ASSERT_TRUE(hand.links[0].inertial);
  EXPECT_NEAR(hand.links[0].inertial->mass, 0.25, 1e-15);
  EXPECT_NEAR(hand.links[0].inertial->inertia(1, 1), 0.25 * 200e-6, 1e-15);
  // The textbook's product.
  const auto dh = [](double theta, double d, double a, double alpha) {
    RigidTransform X = RigidTransform::Identity();
    X.rotate(Eigen::AngleAxisd(theta, Eigen::Vector3d::UnitZ()));
    X.translate(Eigen::Vector3d(0, 0, d));
    X.translate(Eigen::Vector3d(a, 0, 0));
    X.rotate(Eigen::AngleAxisd(alpha, Eigen::Vector3d::UnitX()));
    return X;
  };
  constexpr double kDegree = std::numbers::pi / 180;
  RigidTransform X = RigidTransform::Identity();
  X.translate(Eigen::Vector3d(0.01, 0.02, 0.03));
  X.rotate(Eigen::AngleAxisd(90 * kDegree, Eigen::Vector3d::UnitX()));
  const double motor = 0.6, slide = 0.013;
  X = X * dh(motor + 15 * kDegree, 0.005, 0.05, -90 * kDegree);
  const auto poses = link_poses(hand, {{"chain0_joint0", motor}, {"chain0_joint2", slide}});
  EXPECT_TRUE(poses.at("chain0_link0").isApprox(X, 1e-12));
  X = X * dh(0.333 * motor + 40 * kDegree, 0, 0.04, 0);
  EXPECT_TRUE(poses.at("chain0_link1").isApprox(X, 1e-12));
  X = X * dh(30 * kDegree, slide - 0.002, 0.007, 10 * kDegree);
  EXPECT_TRUE(poses.at("chain0_link2").isApprox(X, 1e-12));
  EXPECT_NEAR(*hand.joint("chain0_joint0")->upper, 140 * kDegree, 1e-12);
  EXPECT_NEAR(*hand.joint("chain0_joint0")->effort, 2.5, 1e-12);
  EXPECT_EQ(*hand.joint("chain0_joint1")->break_away, 0.5);
  EXPECT_EQ(hand.actuators.size(), 2U);
  ASSERT_EQ(hand.sensors.size(), 1U);
  EXPECT_EQ(hand.sensors[0].link, "chain0_link1");
  EXPECT_TRUE(hand.sensors[0].size.isApprox(Eigen::Vector3d(0.002, 0.004, 0.006), 1e-12));
  EXPECT_THAT(loss_.text(), AllOf(HasSubstr("'gone.xml': the file is not there"),
                                  HasSubstr("GraspIt! itself reads 0 after a '-'")));
  for (const char* format : {"urdf", "sdf"}) {
    const ModelDifference found = difference(hand, written_and_read(hand, format));
    EXPECT_LT(std::max(found.place, found.turn), 1e-9) << format;
  }
}

}  // namespace
}  // namespace prehend::robot::formats
