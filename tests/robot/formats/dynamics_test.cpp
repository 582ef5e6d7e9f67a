// Written in one format and from there in another, robots weigh for their motors what they weighed.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>

#include "prehend/robot/formats/model_check.h"
#include "tests/robot/formats/mass_matrix.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;

using DynamicsOf = RobotFiles;

/// Masses do not depend on shapes, which only cost time here. Inertias that no body has, which MJCF
/// does not take, are made those of balls.
RobotDescription weighed(RobotDescription robot) {
  for (LinkDescription& link : robot.links) {
    link.visuals.clear();
    link.collisions.clear();
    if (!link.inertial) continue;
    const double trace = link.inertial->inertia.trace();
    if (!(link.inertial->inertia.determinant() > 1e-9 * trace * trace * trace)) {
      link.inertial->inertia = 1e-4 * link.inertial->mass * Eigen::Matrix3d::Identity();
    }
  }
  return robot;
}

void expect_same_weight(const RobotDescription& given, RobotDescription again) {
  // MuJoCo moves nothing without a mass: 1e-9 kg stands for none, which the report says.
  constexpr double kNone = 1e-8;  // kg
  for (LinkDescription& link : again.links) {
    const LinkDescription* its = given.link(link.name);
    const bool had_one = its && its->inertial && its->inertial->mass > 0;
    if (!had_one && link.inertial && link.inertial->mass < kNone) link.inertial.reset();
  }
  for (const LinkDescription& link : given.links) {
    if (!link.inertial) continue;
    const LinkDescription* other = again.link(link.name);
    ASSERT_TRUE(other && other->inertial) << link.name;
    EXPECT_EQ(link.inertial->mass, other->inertial->mass) << link.name;
  }
  std::vector<std::string> joints;
  for (const JointDescription& joint : given.joints) {
    if (joint.kind == JointDescription::Kind::kFixed) continue;
    const bool is_stuck = joint.lower && joint.upper && *joint.lower >= *joint.upper;
    if (is_stuck) continue;  // some formats have it fixed, which the report says
    const JointDescription* other = again.joint(joint.name);
    ASSERT_NE(other, nullptr) << joint.name;
    EXPECT_EQ(joint.kind, other->kind) << joint.name;
    if (joint.lower && joint.upper) {
      ASSERT_TRUE(other->lower && other->upper) << joint.name;
      EXPECT_EQ(joint.lower, other->lower) << joint.name;
      EXPECT_EQ(joint.upper, other->upper) << joint.name;
    }
    if (moves_by_itself(joint)) joints.push_back(joint.name);
  }
  std::mt19937 random(7);
  for (int sample = 0; sample < 100; ++sample) {
    const auto q = random_positions(given, random);
    const Eigen::MatrixXd M = mass_matrix(given, joints, q), its = mass_matrix(again, joints, q);
    ASSERT_LE((M - its).norm(), 1e-9 * M.norm()) << "sample " << sample;
  }
  const ModelDifference found = difference(given, again, 100);
  EXPECT_LT(found.place, 1e-9) << found.where;
  EXPECT_LT(found.turn, 1e-9) << found.where;
}

TEST_F(DynamicsOf, OwnRobotsAreTheSameOverEveryPairOfFormats) {
  int robots = 0;
  for (const auto& entry : fs::directory_iterator("config/robots")) {
    if (entry.path().extension() != ".urdf") continue;
    ++robots;
    LossReport loss;
    const RobotDescription given = weighed(read_robot(entry.path(), loss));
    for (const std::string& first : written_formats()) {
      const RobotDescription between = written_and_read(given, first);
      for (const std::string& second : written_formats()) {
        SCOPED_TRACE(entry.path().filename().string() + " over " + first + " and " + second);
        expect_same_weight(given, written_and_read(between, second));
      }
    }
  }
  EXPECT_GE(robots, 10);
}

TEST_F(DynamicsOf, RobotsOfOthersAreTheSameOverEveryPairOfFormats) {
  if (shared_model("").empty()) GTEST_SKIP() << "no shared models";
  for (const char* name :
       {"urdf/panda_ign/urdf/panda.urdf", "sdf/gazebo_models/simple_gripper/model.sdf",
        "urdf/allegro_hand_description/allegro_hand_description_right.urdf",
        "graspit/HumanHand/HumanHand20DOF.xml", "openrave/barrett-wam-sensors.zae",
        "simox/Schunk_SAH/SAH_RightHand.xml"}) {
    const fs::path file = shared_model(name);
    ASSERT_FALSE(file.empty()) << name;
    LossReport loss;
    const RobotDescription given = weighed(read_robot(file, loss));
    for (const std::string& first : written_formats()) {
      const RobotDescription between = written_and_read(given, first);
      for (const std::string& second : written_formats()) {
        SCOPED_TRACE(std::string(name) + " over " + first + " and " + second);
        expect_same_weight(given, written_and_read(between, second));
      }
    }
  }
}

// The textbook's: a mass on a massless rod of length r has m r^2; on a slide m.
TEST(MassMatrix, IsThatOfAPendulumOnASlide) {
  RobotDescription robot;
  Inertial ball;
  ball.mass = 2;
  ball.inertia = 0.01 * Eigen::Matrix3d::Identity();
  robot.links = {{"rail", {}, {}, {}}, {"cart", {}, {}, {}}, {"rod", ball, {}, {}}};
  robot.links[2].inertial->X_LI.translation() = Eigen::Vector3d(0, 0, -0.5);
  JointDescription slide, hinge;
  slide.name = "slide";
  slide.kind = JointDescription::Kind::kPrismatic;
  slide.parent = "rail";
  slide.child = "cart";
  slide.axis_J = Eigen::Vector3d::UnitX();
  hinge.name = "hinge";
  hinge.kind = JointDescription::Kind::kRevolute;
  hinge.parent = "cart";
  hinge.child = "rod";
  hinge.axis_J = Eigen::Vector3d::UnitY();
  robot.joints = {slide, hinge};
  const double q = 0.3;
  const Eigen::MatrixXd M = mass_matrix(robot, {"slide", "hinge"}, {{"hinge", q}});
  EXPECT_NEAR(M(0, 0), 2, 1e-12);
  EXPECT_NEAR(M(1, 1), 2 * 0.25 + 0.01, 1e-12);
  EXPECT_NEAR(M(0, 1), -2 * 0.5 * std::cos(q), 1e-12);
}

}  // namespace
}  // namespace prehend::robot::formats
