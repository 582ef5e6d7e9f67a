// Links that overlap at rest.

#include <gmock/gmock.h>

#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/overlap.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A rail with two boxes of 0.1 m on it, on slides of their own whose places are `apart` from one
/// another.
RobotDescription two_boxes(double apart) {
  RobotDescription robot;
  robot.name = "rail";
  Shape box;
  box.size = Eigen::Vector3d(0.1, 0.2, 0.3);
  robot.links = {{"rail", {}, {}, {}}, {"left", {}, {}, {box}}, {"right", {}, {}, {box}}};
  for (const char* child : {"left", "right"}) {
    JointDescription slide;
    slide.name = std::string(child) + "_slide";
    slide.kind = JointDescription::Kind::kPrismatic;
    slide.parent = "rail";
    slide.child = child;
    slide.axis_J = Eigen::Vector3d::UnitX();
    robot.joints.push_back(slide);
  }
  robot.joints[1].X_PJ.translation().x() = apart;
  return robot;
}

std::vector<LinkOverlap> overlaps(const RobotDescription& robot) {
  ShapeMeshes meshes(".");
  return overlaps_at_rest(robot, meshes);
}

TEST(Overlap, OfTwoBoxesIsTheirsToTheMicron) {
  const auto found = overlaps(two_boxes(0.095));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].first, "left");
  EXPECT_EQ(found[0].second, "right");
  EXPECT_NEAR(found[0].depth, 0.005, 1e-6);
  std::string all;
  for (const ModelFinding& one : check_model(two_boxes(0.095), ".")) {
    all += one.place + " " + one.what + "\n";
  }
  EXPECT_THAT(all, HasSubstr("link 'left' and link 'right' overlap by 5.0 mm at rest"));
}

TEST(Overlap, WhatTouchesDoesNot) {
  EXPECT_TRUE(overlaps(two_boxes(0.1)).empty());
  EXPECT_TRUE(overlaps(two_boxes(0.0995)).empty());  // less than a millimetre
  EXPECT_TRUE(overlaps(two_boxes(0.2)).empty());
}

TEST(Overlap, IsAtTheLimitNearestToZero) {
  RobotDescription robot = two_boxes(0.095);
  robot.joints[1].lower = 0.01;
  robot.joints[1].upper = 0.05;
  EXPECT_TRUE(overlaps(robot).empty());
  robot.joints[1].lower = -0.05;
  robot.joints[1].upper = -0.01;
  ASSERT_EQ(overlaps(robot).size(), 1U);
  EXPECT_NEAR(overlaps(robot)[0].depth, 0.015, 1e-6);
}

TEST(Overlap, OfPairsThatMayTouchIsNone) {
  RobotDescription robot = two_boxes(0.095);
  robot.disabled_collisions = {{"right", "left"}};
  EXPECT_TRUE(overlaps(robot).empty());
  robot = two_boxes(0.095);
  robot.loops.push_back({"closed", Loop::Kind::kPoint, "left", "right", {}});
  EXPECT_TRUE(overlaps(robot).empty());
}

TEST(Overlap, OfParentAndChildIsNoneAlsoOverFixedJoints) {
  RobotDescription robot = two_boxes(0.095);
  robot.joints[1].parent = "left";
  EXPECT_TRUE(overlaps(robot).empty());
  // Left, a flange on it, and right on that.
  robot.links.push_back({"flange", {}, {}, {}});
  JointDescription fixed;
  fixed.name = "weld";
  fixed.parent = "left";
  fixed.child = "flange";
  robot.joints.push_back(fixed);
  robot.joints[1].parent = "flange";
  EXPECT_TRUE(overlaps(robot).empty());
  robot.joints.back().kind = JointDescription::Kind::kRevolute;  // a grandchild
  EXPECT_EQ(overlaps(robot).size(), 1U);
}

// A ball in a bowl: the hulls overlap, the meshes do not. A box within a box does.
TEST(Overlap, OfHollowShapesIsToldByTheirMeshes) {
  RobotDescription robot = two_boxes(0);
  Shape bowl;
  bowl.kind = Shape::Kind::kMesh;
  bowl.mesh = "bowl";
  bowl.surface = std::make_shared<const geometry::TriangleMesh>(geometry::make_revolution(
      {{0, -0.05}, {0.1, -0.05}, {0.1, 0.05}, {0.08, 0.05}, {0.08, -0.03}, {0, -0.03}}, 48));
  robot.links[1].collisions = {bowl};
  robot.links[2].collisions[0].size = Eigen::Vector3d::Constant(0.03);
  EXPECT_TRUE(overlaps(robot).empty());
  robot.joints[1].X_PJ.translation().x() = 0.07;
  EXPECT_EQ(overlaps(robot).size(), 1U);
  robot = two_boxes(0);
  robot.links[2].collisions[0].size = Eigen::Vector3d::Constant(0.02);
  EXPECT_EQ(overlaps(robot).size(), 1U);
}

TEST(Overlap, OfWrongTreesIsNotLookedFor) {
  RobotDescription robot = two_boxes(0.095);
  robot.joints[0].follows = Follows{"left_slide", 1, 0};
  std::string all;
  for (const ModelFinding& one : check_model(robot, ".")) all += one.what + "\n";
  EXPECT_THAT(all, HasSubstr("follows itself"));
  EXPECT_THAT(all, Not(HasSubstr("overlap")));
}

}  // namespace
}  // namespace prehend::robot::formats
