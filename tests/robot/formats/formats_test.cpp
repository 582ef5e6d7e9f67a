// Robots' files of many formats: read, written, compared.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <minizip/zip.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/robot_format.h"
#include "prehend/robot/formats/xml_text.h"
#include "prehend/robot/robot_model.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;
using geometry::InputError;
using geometry::RigidTransform;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using Kind = JointDescription::Kind;

class Formats : public testing::Test {
 protected:
  Formats() { fs::create_directories(folder_); }
  ~Formats() override { fs::remove_all(folder_); }
  fs::path file(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  RobotDescription read(const std::string& name, const std::string& text) {
    loss_ = {};
    return read_robot(file(name, text), loss_);
  }
  std::string error_of(const std::string& name, const std::string& text) {
    try {
      read(name, text);
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }
  RobotDescription written_and_read(const RobotDescription& robot, const std::string& format) {
    LossReport unused;
    const fs::path path = folder_ / ("again" + format_named(format).ending());
    std::ofstream(path) << format_named(format).write(robot, unused);
    return read_robot(path, unused);
  }
  const fs::path folder_ =
      fs::temp_directory_path() / ("prehend_formats_" + std::to_string(::getpid()));
  LossReport loss_;
};

const std::string kArm = R"(<?xml version="1.0"?>
<robot name="arm">
  <material name="steel"><color rgba="0.5 0.5 0.6 1"/></material>
  <link name="base"/>
  <link name="upper">
    <inertial><origin xyz="0 0 0.1" rpy="0 0.1 0"/><mass value="2"/>
      <inertia ixx="0.02" ixy="0" ixz="0.001" iyy="0.02" iyz="0" izz="0.01"/></inertial>
    <visual><geometry><cylinder radius="0.04" length="0.2"/></geometry><material name="steel"/></visual>
    <collision name="hull"><origin xyz="0 0 0.1"/><geometry><box size="0.1 0.1 0.3"/></geometry></collision>
  </link>
  <link name="lower"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <link name="tip"/>
  <joint name="shoulder" type="revolute"><origin xyz="0.1 0 0.3" rpy="0.2 -0.4 1.5"/>
    <parent link="base"/><child link="upper"/><axis xyz="0 0.6 0.8"/>
    <limit lower="-2" upper="1.5" effort="30" velocity="2"/><dynamics damping="0.1" friction="0.2"/></joint>
  <joint name="elbow" type="prismatic"><origin xyz="0 0 0.2"/><parent link="upper"/><child link="lower"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.1" effort="10" velocity="0.5"/>
    <mimic joint="shoulder" multiplier="0.02" offset="0.03"/></joint>
  <joint name="end" type="fixed"><origin rpy="0 1.5707963267948966 0"/><parent link="lower"/><child link="tip"/></joint>
  <gazebo reference="upper"><mu1>0.2</mu1></gazebo>
</robot>)";

TEST_F(Formats, UrdfIsReadWhole) {
  const RobotDescription arm = read("arm.urdf", kArm);
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
TEST_F(Formats, UrdfStandsWhereUrdfdomHasIt) {
  const RobotDescription arm = read("arm.urdf", kArm);
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

TEST_F(Formats, WhatIsWrittenDoesTheSame) {
  const RobotDescription arm = read("arm.urdf", kArm);
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

TEST_F(Formats, UnknownPartsAreSaidWithTheirPlace) {
  std::string text = kArm;
  text.replace(text.find("<link name=\"base\"/>"), 19,
               "<link name=\"base\" colour=\"red\"><soul weight=\"21\"><deep/></soul></link>");
  read("arm.urdf", text);
  std::vector<std::string> lost;
  for (const auto& entry : loss_.entries()) lost.push_back(entry.what);
  EXPECT_THAT(lost, AllOf(Contains("robot/link/@colour"), Contains("robot/link/soul")));
  EXPECT_THAT(lost, testing::Not(Contains("robot/link/soul/deep")));  // it is in what was dropped
  EXPECT_THAT(loss_.text(), HasSubstr("3 dropped"));
}

TEST_F(Formats, BadFilesAreRefusedInWords) {
  EXPECT_THAT(error_of("a.urdf", "<robot><link"), HasSubstr("a.urdf:1 is no well-formed XML"));
  EXPECT_THAT(error_of("a.urdf", ""), HasSubstr("empty"));
  EXPECT_THAT(error_of("a.xml", "<page/>"), AllOf(HasSubstr("<page>"), HasSubstr("urdf")));
  const auto with_joint = [](const std::string& joint) {
    return "<robot name='r'><link name='a'/><link name='b'/>" + joint + "</robot>";
  };
  EXPECT_THAT(error_of("a.urdf", with_joint("<joint name='j' type='hinge'><parent link='a'/>"
                                            "<child link='b'/></joint>")),
              HasSubstr("'hinge'"));
  EXPECT_THAT(error_of("a.urdf", with_joint("<joint name='j' type='fixed'><parent link='a'/>"
                                            "<child link='c'/></joint>")),
              HasSubstr("'c'"));
  EXPECT_THAT(error_of("a.urdf", with_joint("")), HasSubstr("both have no joint above"));
  EXPECT_THAT(error_of("a.urdf", with_joint("<joint name='j' type='fixed'><origin xyz='1 2 x'/>"
                                            "<parent link='a'/><child link='b'/></joint>")),
              HasSubstr("'x' is no number"));
  EXPECT_THAT(error_of("a.urdf", with_joint("<joint name='j' type='fixed'><origin xyz='1 nan 2'/>"
                                            "<parent link='a'/><child link='b'/></joint>")),
              HasSubstr("nan"));
  EXPECT_THAT(error_of("a.urdf", with_joint("<joint name='j' type='fixed'><parent link='a'/>"
                                            "<child link='b'/></joint><joint name='k' type='fixed'>"
                                            "<parent link='b'/><child link='a'/></joint>")),
              HasSubstr("ring"));
  EXPECT_THAT(error_of("a.urdf", "<robot xmlns:xacro='x'><xacro:arm/></robot>"),
              HasSubstr("xacro"));
  EXPECT_THROW(format_named("urfd"), InputError);
  EXPECT_THROW(format_for("robot.txt"), InputError);
}

TEST_F(Formats, EntitiesDoNotGrow) {
  std::string bomb = "<?xml version='1.0'?><!DOCTYPE r [<!ENTITY a 'aaaaaaaaaa'>";
  for (char c = 'b'; c < 'k'; ++c) {
    bomb += std::string("<!ENTITY ") + c + " '";
    for (int i = 0; i < 10; ++i) bomb += std::string("&") + static_cast<char>(c - 1) + ";";
    bomb += "'>";
  }
  bomb += "]><robot name='&j;'><link name='a'/></robot>";
  const auto begin = std::chrono::steady_clock::now();
  try {
    EXPECT_LT(read("bomb.urdf", bomb).name.size(), 100U);
  } catch (const InputError&) {
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
  std::string deep = "<robot name='r'>";
  for (int i = 0; i < 100000; ++i) deep += "<link>";
  EXPECT_FALSE(error_of("deep.urdf", deep).empty());
}

TEST_F(Formats, ManyLinksStayQuick) {
  std::string text = "<robot name='chain'><link name='l0'/>";
  for (int i = 1; i < 2000; ++i) {
    const std::string n = std::to_string(i), before = std::to_string(i - 1);
    text += "<link name='l" + n + "'/><joint name='j" + n + "' type='continuous'><parent link='l" +
            before + "'/><child link='l" + n + "'/></joint>";
  }
  EXPECT_EQ(read("chain.urdf", text + "</robot>").links.size(), 2000U);
}

TEST_F(Formats, SdfPosesAreGivenInFrames) {
  const RobotDescription robot = read("r.sdf", R"(<sdf version="1.7"><model name="m">
    <frame name="stand"><pose>0 0 1 0 0 0</pose></frame>
    <link name="a"><pose relative_to="stand">0 0 0.5 0 0 0</pose></link>
    <link name="b"><pose relative_to="a">1 0 0 0 0 1.5707963267948966</pose></link>
    <joint name="b" type="revolute"><pose>0 -0.5 0 0 0 0</pose><parent>a</parent><child>b</child>
      <axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint>
    </model></sdf>)");
  const auto poses = link_poses(robot, {});
  EXPECT_TRUE(poses.at("b").translation().isApprox(Eigen::Vector3d(1, 0, 0), 1e-12));
  // It turns about a place beside its origin: -0.5 along the link's y is +0.5 along x of a's.
  const auto turned = link_poses(robot, {{"b", std::numbers::pi / 2}});
  EXPECT_TRUE(turned.at("b").translation().isApprox(Eigen::Vector3d(1.5, -0.5, 0), 1e-12))
      << turned.at("b").translation().transpose();
  for (const char* format : {"urdf", "sdf"}) {
    const RobotDescription again = written_and_read(robot, format);
    EXPECT_LT(difference(robot, again).place, 1e-9) << format;
  }
}

TEST_F(Formats, SdfAxesUntilFourAreTheModels) {
  const auto axis_of = [&](const char* version) {
    const RobotDescription robot =
        read("r.sdf", std::string("<sdf version='") + version +
                          "'><model name='m'><link name='a'/><link name='b'><pose>0 0 0 0 0 "
                          "1.5707963267948966</pose></link><joint name='j' type='revolute'>"
                          "<parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz></axis></joint>"
                          "</model></sdf>");
    return robot.joints[0].axis_J;
  };
  EXPECT_TRUE(axis_of("1.4").isApprox(Eigen::Vector3d(0, -1, 0), 1e-12));
  EXPECT_TRUE(axis_of("1.5").isApprox(Eigen::Vector3d(1, 0, 0), 1e-12));
}

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

TEST_F(Formats, GraspItHandsAreChainsByDenavitAndHartenberg) {
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

const std::string kKinBody = R"(<KinBody name="arm">
  <Body name="base" type="static"><Geom type="cylinder"><radius>0.1</radius><height>0.2</height></Geom></Body>
  <Body name="Upper"><offsetfrom>base</offsetfrom><Translation>0 0 0.3</Translation><rotationaxis>0 0 1 90</rotationaxis>
    <mass type="box"><total>3</total><extents>0.1 0.1 0.2</extents></mass></Body>
  <Body name="lower"><offsetfrom>Upper</offsetfrom><translation>0.2 0 0</translation>
    <geom type="box"><extents>0.1 0.2 0.3</extents></geom></Body>
  <Joint name="J1" type="hinge"><Body>base</Body><Body>Upper</Body><offsetfrom>Upper</offsetfrom><axis>0 1 0</axis>
    <anchor>0 0 0.05</anchor><lostop>-90</lostop><histop>45</histop><maxvel>2</maxvel></Joint>
  <Joint name="J2" type="slider" mimic_pos="J1/4+0.02"><Body>Upper</Body><Body>lower</Body><offsetfrom>lower</offsetfrom>
    <axis>0 0 1</axis><limits>0.5 0</limits></Joint>
</KinBody>)";

TEST_F(Formats, OpenRaveJointsHaveAnAnchorAndOldStopsTurnTheOtherWay) {
  const RobotDescription arm = read("arm.kinbody.xml", kKinBody);
  EXPECT_NEAR(*arm.joint("J1")->lower, -std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(*arm.joint("J2")->upper, 0.5);
  EXPECT_NEAR(arm.link("Upper")->inertial->inertia(2, 2), 3.0 / 3 * 0.02, 1e-12);
  EXPECT_EQ(arm.link("lower")->collisions[0].size.y(), 0.4);
  // The cylinder stands along y.
  EXPECT_TRUE((arm.link("base")->collisions[0].X_LS.linear() * Eigen::Vector3d::UnitZ())
                  .isApprox(Eigen::Vector3d::UnitY(), 1e-12));
  const double q = 0.4;
  RigidTransform upper = RigidTransform::Identity();
  upper.translate(Eigen::Vector3d(0, 0, 0.3));
  upper.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
  RigidTransform about = RigidTransform::Identity();
  about.translate(Eigen::Vector3d(0, 0, 0.05));
  about.rotate(Eigen::AngleAxisd(-q, Eigen::Vector3d::UnitY()));
  about.translate(Eigen::Vector3d(0, 0, -0.05));
  const auto poses = link_poses(arm, {{"J1", q}});
  EXPECT_TRUE(poses.at("Upper").isApprox(upper * about, 1e-12));
  RigidTransform lower = RigidTransform::Identity();
  lower.translate(Eigen::Vector3d(0.2, 0, q / 4 + 0.02));
  EXPECT_TRUE(poses.at("lower").isApprox(upper * about * lower, 1e-12));
  for (const char* format : {"urdf", "sdf"}) {
    const ModelDifference found = difference(arm, written_and_read(arm, format));
    EXPECT_LT(std::max(found.place, found.turn), 1e-9) << format;
  }
}

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

TEST_F(Formats, SimoxNodesArePosesWithAJoint) {
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

/// In centimetres; a finger that follows, and a body that is tied to its link's node.
std::string collada(const std::string& formula) {
  return R"(<COLLADA xmlns="http://www.collada.org/2008/03/COLLADASchema" version="1.5.0">
  <asset><contributor><authoring_tool>by hand</authoring_tool></contributor><unit meter="0.01" name="cm"/></asset>
  <library_joints><joint id="j0" name="turn"><revolute sid="axis0"><axis>0 0 2</axis>
    <limits><min>-90</min><max>45</max></limits></revolute></joint></library_joints>
  <library_visual_scenes><visual_scene id="v"><node id="n1" name="arm"/></visual_scene></library_visual_scenes>
  <library_kinematics_models><kinematics_model id="k" name="lift"><technique_common>
    <instance_joint url="#j0" sid="first"/>
    <joint sid="second" name="slide"><prismatic sid="axis0"><axis>1 0 0</axis></prismatic></joint>
    <link sid="l0" name="base"><attachment_full joint="k/first"><rotate>0 1 0 90</rotate><translate>10 0 0</translate>
      <link sid="l1" name="arm"><attachment_full joint="k/second"><translate>0 20 0</translate>
        <link sid="l2" name="tip"><translate>0 0 5</translate></link></attachment_full></link></attachment_full></link>
    <formula><target><param>k/second/axis0</param></target><technique_common>)" +
         formula + R"(</technique_common></formula>
  </technique_common></kinematics_model></library_kinematics_models>
  <library_articulated_systems>
    <articulated_system id="a"><kinematics><technique_common>
      <axis_info sid="i0" axis="k/first/axis0"><limits><min><float>-60</float></min></limits></axis_info></technique_common></kinematics>
      <extra type="manipulator" name="arm"/></articulated_system>
    <articulated_system id="m"><motion><technique_common>
      <axis_info axis="a/i0"><speed><float>90</float></speed></axis_info></technique_common></motion></articulated_system>
  </library_articulated_systems>
  <library_physics_models><physics_model id="p"><rigid_body sid="b1"><technique_common><mass>3</mass>
    <mass_frame><translate>0 7 0</translate></mass_frame><inertia>0.1 0.2 0.15</inertia></technique_common></rigid_body></physics_model></library_physics_models>
  <library_physics_scenes><physics_scene id="s"><instance_physics_model url="#p">
    <instance_rigid_body body="b1" target="#n1"/></instance_physics_model></physics_scene></library_physics_scenes>
</COLLADA>)";
}
const std::string kHalfAndAThousandth =
    "<math><apply><plus/><apply><times/><cn>0.5</cn><csymbol>k/first</csymbol></apply>"
    "<cn>0.001</cn></apply></math>";

TEST_F(Formats, ColladaLinksHangInOneAnother) {
  const RobotDescription lift = read("lift.dae", collada(kHalfAndAThousandth));
  ASSERT_EQ(lift.links.size(), 3U);
  const JointDescription& turn = *lift.joint("turn");
  constexpr double kDegree = std::numbers::pi / 180;
  EXPECT_NEAR(*turn.lower, -60 * kDegree, 1e-12);  // the soft one
  EXPECT_NEAR(*turn.upper, 45 * kDegree, 1e-12);
  EXPECT_NEAR(turn.velocity.value_or(0), 90 * kDegree, 1e-12);
  EXPECT_EQ(lift.joint("slide")->follows->joint, "turn");
  const double q = 0.4;
  RigidTransform X = RigidTransform::Identity();
  X.rotate(Eigen::AngleAxisd(90 * kDegree, Eigen::Vector3d::UnitY()));
  X.translate(Eigen::Vector3d(0.1, 0, 0));
  X.rotate(Eigen::AngleAxisd(q, Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(link_poses(lift, {{"turn", q}}).at("arm").isApprox(X, 1e-12));
  X.translate(Eigen::Vector3d(0.5 * q + 0.001, 0.2, 0.05));
  EXPECT_TRUE(link_poses(lift, {{"turn", q}}).at("tip").isApprox(X, 1e-12));
  // The frame of a mass is the model's, not the link's.
  const auto& inertial = lift.link("arm")->inertial;
  ASSERT_TRUE(inertial);
  EXPECT_EQ(inertial->mass, 3);
  EXPECT_TRUE((link_poses(lift, {}).at("arm") * inertial->X_LI)
                  .isApprox(RigidTransform(Eigen::Translation3d(0, 0.07, 0)), 1e-12));
  EXPECT_THAT(loss_.text(), HasSubstr("extra: it is of its writer's own"));
}

TEST_F(Formats, ColladaFormulasThatAreNoLineAreSaid) {
  const auto follows = [&](const std::string& formula) {
    return read("lift.dae", collada(formula)).joint("slide")->follows.has_value();
  };
  EXPECT_FALSE(
      follows("<math><apply><times/><csymbol>k/first</csymbol><csymbol>k/first</csymbol>"
              "</apply></math>"));
  EXPECT_THAT(loss_.text(), HasSubstr("no linear formula"));
  EXPECT_FALSE(follows("<math><csymbol>k/nowhere</csymbol></math>"));
  EXPECT_THAT(loss_.text(), HasSubstr("'nowhere' in it is not there"));
  EXPECT_FALSE(
      follows("<math><apply><divide/><cn>1</cn><csymbol>k/first</csymbol></apply></math>"));
  EXPECT_FALSE(
      follows("<math><apply><divide/><csymbol>k/first</csymbol><csymbol>k/first"
              "</csymbol></apply></math>"));
  EXPECT_THAT(error_of("a.dae", collada("<math><apply><tan/><cn>1</cn></apply></math>")),
              HasSubstr("<tan> is not read"));
  EXPECT_THAT(error_of("b.dae", collada("<math/>")), HasSubstr("empty"));
  EXPECT_THAT(error_of("mesh.dae", "<COLLADA version='1.4.1'><library_geometries/></COLLADA>"),
              HasSubstr("no kinematics"));
}

/// A zip of files by name.
void pack(const fs::path& archive, const std::vector<std::pair<std::string, std::string>>& files) {
  zipFile zip = zipOpen(archive.c_str(), APPEND_STATUS_CREATE);
  ASSERT_TRUE(zip);
  for (const auto& [name, text] : files) {
    ASSERT_EQ(zipOpenNewFileInZip(zip, name.c_str(), nullptr, nullptr, 0, nullptr, 0, nullptr,
                                  Z_DEFLATED, 9),
              ZIP_OK);
    zipWriteInFileInZip(zip, text.data(), static_cast<unsigned>(text.size()));
    zipCloseFileInZip(zip);
  }
  zipClose(zip, nullptr);
}

TEST_F(Formats, ZippedColladaIsBoundedAndWhole) {
  const std::string text = collada(kHalfAndAThousandth);
  const std::string manifest = "<dae_root>./lift.dae#main</dae_root>";
  const auto error_of_zip = [&](const std::vector<std::pair<std::string, std::string>>& files) {
    pack(folder_ / "r.zae", files);
    try {
      read_robot(folder_ / "r.zae", loss_);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(error_of_zip({{"manifest.xml", manifest}, {"lift.dae", text}}), "");
  EXPECT_THAT(error_of_zip({{"lift.dae", text}}), HasSubstr("'manifest.xml' in it is not there"));
  EXPECT_THAT(error_of_zip({{"manifest.xml", manifest}}), HasSubstr("'lift.dae' in it"));
  EXPECT_THAT(error_of_zip({{"manifest.xml", "<dae_root>../../etc/passwd</dae_root>"}}),
              HasSubstr("is not there"));
  // 100 MB of blanks in 100 kB.
  EXPECT_THAT(error_of_zip({{"manifest.xml", manifest}, {"lift.dae", std::string(100 << 20, ' ')}}),
              HasSubstr("larger than 64 MiB"));
  // Cut, and with one byte changed.
  pack(folder_ / "r.zae", {{"manifest.xml", manifest}, {"lift.dae", text}});
  std::ifstream stream(folder_ / "r.zae", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_THAT(error_of("cut.zae", bytes.substr(0, bytes.size() / 2)), HasSubstr("no whole zip"));
  std::string changed = bytes;
  changed[bytes.find("lift.dae") + 200] ^= 0x55;
  EXPECT_THAT(error_of("changed.zae", changed), HasSubstr("is damaged"));
}

TEST_F(Formats, MjcfIsReadByMuJoCo) {
  if (std::none_of(robot_formats().begin(), robot_formats().end(),
                   [](const auto& one) { return one->name() == "mjcf"; })) {
    GTEST_SKIP() << "MuJoCo is not there";
  }
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

TEST_F(Formats, CheckNamesWhatNoBodyHas) {
  std::string text = kArm;
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("izz=\"0.01\"", "izz=\"0.09\"");
  replace("lower=\"-2\" upper=\"1.5\"", "lower=\"2\" upper=\"-1.5\"");
  replace("<sphere radius=\"0.05\"/>", "<mesh filename=\"gone.stl\" scale=\"1 -1 1\"/>");
  replace("effort=\"30\"", "effort=\"0\"");
  const RobotDescription arm = read("arm.urdf", text);
  std::string all;
  for (const ModelFinding& one : check_model(arm, folder_))
    all += one.place + ": " + one.what + "\n";
  EXPECT_THAT(all, HasSubstr("link 'upper': has principal inertias"));
  EXPECT_THAT(all, HasSubstr("joint 'shoulder': has limits that are exchanged"));
  EXPECT_THAT(all, HasSubstr("link 'lower': names a mesh that is not there"));
  EXPECT_THAT(all, HasSubstr("link 'lower': mirrors the mesh"));
  EXPECT_THAT(all, HasSubstr("joint 'shoulder': has no effort"));
  EXPECT_THAT(all, HasSubstr("link 'lower': moves and has no inertia"));
  RobotDescription mended = arm;
  EXPECT_THAT(mend_model(mended, "."), Contains(HasSubstr("limits exchanged")));
  EXPECT_EQ(*mended.joint("shoulder")->lower, -1.5);
}

TEST_F(Formats, InertiaIsComparedWithTheShape) {
  // A box of 2 kg, as its shape has it, and with millimetres taken for metres.
  const auto findings_of = [&](double factor) {
    RobotDescription robot = read("arm.urdf", kArm);
    Inertial& inertial = *robot.links[1].inertial;
    const Eigen::Vector3d s = robot.links[1].collisions[0].size;
    inertial.inertia = factor * inertial.mass / 12 *
                       Eigen::Vector3d(s.y() * s.y() + s.z() * s.z(), s.x() * s.x() + s.z() * s.z(),
                                       s.x() * s.x() + s.y() * s.y())
                           .asDiagonal();
    std::string all;
    for (const ModelFinding& one : check_model(robot, folder_)) {
      if (one.place == "link 'upper'") all += one.what;
    }
    return all;
  };
  EXPECT_EQ(findings_of(1), "");
  EXPECT_THAT(findings_of(1e6), HasSubstr("no shape that far"));
  EXPECT_THAT(findings_of(1e-9), HasSubstr("million times less"));
}

TEST_F(Formats, MeshesAreFoundFromWhereItIsWritten) {
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

/// All files of others that are read go through both formats that are written, and do the same.
TEST_F(Formats, FilesOfOthersComeBackAsTheyWere) {
  const char* shared = std::getenv("PREHEND_SHARED_DATA");
  if (!shared || !fs::is_directory(fs::path(shared) / "models")) GTEST_SKIP() << "no shared models";
  int read_files = 0;
  for (const char* folder : {"models", "robots"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(shared) / folder)) {
      std::string ending = entry.path().extension().string();
      for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      if (ending != ".urdf" && ending != ".sdf" && ending != ".xml" && ending != ".dae" &&
          ending != ".zae") {
        continue;
      }
      RobotDescription robot;
      LossReport loss;
      try {
        robot = read_robot(entry.path(), loss);
      } catch (const InputError&) {
        continue;  // parts, worlds, faults that are wanted
      }
      ++read_files;
      for (const char* format : {"urdf", "sdf"}) {
        RobotDescription again;
        try {
          again = written_and_read(robot, format);
        } catch (const InputError& error) {
          ADD_FAILURE() << entry.path() << " as " << format << ": " << error.what();
          continue;
        }
        const ModelDifference found = difference(robot, again, 50);
        EXPECT_LT(std::max(found.place, found.turn), 1e-9) << entry.path() << " as " << format;
      }
    }
  }
  EXPECT_GE(read_files, 50);
}

// Joints by their makers' own words: the hand is Shadow's C6M, the arm Barrett's WAM with its hand.
TEST_F(Formats, ColladaRobotsOfOthersHaveTheirJoints) {
  const char* shared = std::getenv("PREHEND_SHARED_DATA");
  const fs::path folder = shared ? fs::path(shared) / "models" : fs::path();
  if (!shared || !fs::is_directory(folder)) GTEST_SKIP() << "no shared models";
  const auto moving = [&](const char* name) {
    LossReport loss;
    const RobotDescription robot = read_robot(folder / name, loss);
    return std::count_if(robot.joints.begin(), robot.joints.end(), [](const auto& joint) {
      return joint.kind != Kind::kFixed && !joint.follows;
    });
  };
  EXPECT_EQ(moving("openrave/pumaarm.zae"), 6);
  EXPECT_EQ(moving("openrave/barrett-wam-sensors.zae"), 7 + 4);
  EXPECT_EQ(moving("openhrp/nextage_description/models/main.dae"), 15);
}

// The same arm in two formats, by their own authors.
TEST_F(Formats, ThePandaIsThePanda) {
  const char* shared = std::getenv("PREHEND_SHARED_DATA");
  const fs::path folder = shared ? fs::path(shared) / "models/urdf/panda_ign" : fs::path();
  if (!shared || !fs::is_directory(folder)) GTEST_SKIP() << "no shared models";
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
