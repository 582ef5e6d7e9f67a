#include "eval/resting_pose.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "eval/data_sets.h"
#include "eval/household_objects.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/platform.h"
#include "prehend/simulation/robot_world.h"

namespace prehend::eval {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;

// rad, between the body's z axis and the vertical.
double tilt(const RigidTransform& X_WB) {
  return std::acos(std::clamp(X_WB.linear()(2, 2), -1.0, 1.0));
}

TriangleMesh box(const Eigen::Vector3d& size) {
  TriangleMesh mesh = geometry::make_box(size);
  const double bottom = geometry::bounds(mesh).min().z();
  for (Eigen::Vector3d& v : mesh.vertices) v.z() -= bottom;
  return mesh;
}

TEST(RestingPose, WhatStandsFlatStays) {
  const RigidTransform X_WB = geometry::make_transform(
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ())), {0, 0, 0});
  const RigidTransform X = resting_pose(box({0.06, 0.04, 0.15}), X_WB, 0.2);
  EXPECT_LT((X.matrix() - X_WB.matrix()).norm(), 1e-3);
}

// Once scans with a bulged foot were rendered standing and fell over before the hand came.
TEST(RestingPose, WhatStandsOnAnEdgeFallsOnItsSide) {
  // 20 x 20 x 200 mm leaning by 10 degrees: its centre of mass is beyond its foot.
  const double lean = 10 * std::numbers::pi / 180;
  const RigidTransform X_WB = geometry::make_transform(
      Eigen::Quaterniond(Eigen::AngleAxisd(lean, Eigen::Vector3d::UnitY())), {0, 0, 0});
  const TriangleMesh mesh_B = box({0.02, 0.02, 0.2});
  const RigidTransform X = resting_pose(mesh_B, X_WB, 0.1);
  EXPECT_NEAR(tilt(X), std::numbers::pi / 2, 0.02);
  const Eigen::AlignedBox3d bounds = geometry::bounds(geometry::transformed(mesh_B, X));
  EXPECT_NEAR(bounds.min().z(), 0, 1e-9);
  EXPECT_NEAR(bounds.max().z(), 0.02, 0.001);
  EXPECT_LT(bounds.center().head<2>().norm(), 1e-9);
}

TEST(RestingPose, WhatLeansALittleSitsDown) {
  const double lean = 5 * std::numbers::pi / 180;
  const RigidTransform X_WB = geometry::make_transform(
      Eigen::Quaterniond(Eigen::AngleAxisd(lean, Eigen::Vector3d::UnitX())), {0, 0, 0});
  EXPECT_LT(tilt(resting_pose(box({0.06, 0.06, 0.1}), X_WB, 0.2)), 0.005);
}

// It would fall on the table without them.
TEST(RestingPose, WhatStandsOnAnotherStaysThere) {
  const TriangleMesh support = box({0.1, 0.1, 0.05});
  const RigidTransform X_WB =
      geometry::make_transform(Eigen::Quaterniond::Identity(), {0.01, 0, 0.05});
  const RigidTransform X = resting_pose(box({0.06, 0.06, 0.08}), X_WB, 0.2, {support});
  EXPECT_LT((X.matrix() - X_WB.matrix()).norm(), 1e-3);
}

TEST(RestingPose, WhatLeansOnAnotherDoesNotFallOver) {
  // 20 x 20 x 200 mm leaning by 10 degrees against a wall.
  const double lean = 10 * std::numbers::pi / 180;
  const RigidTransform X_WB = geometry::make_transform(
      Eigen::Quaterniond(Eigen::AngleAxisd(lean, Eigen::Vector3d::UnitY())), {0, 0, 0});
  const TriangleMesh mesh_B = box({0.02, 0.02, 0.2});
  TriangleMesh wall = box({0.02, 0.2, 0.15});
  const double reach = std::cos(lean) * 0.01 + std::tan(lean) * 0.15;  // of the rod at its top
  for (Eigen::Vector3d& p : wall.vertices) p.x() += reach + 0.012;
  EXPECT_LT(tilt(resting_pose(mesh_B, X_WB, 0.1, {wall})), 25 * std::numbers::pi / 180);
}

TEST(RestingPose, RefusesWhatHasNoVolume) {
  EXPECT_THROW(resting_pose(TriangleMesh{}, RigidTransform::Identity(), 0.1), geometry::InputError);
}

TEST(Settled, ACubeStays) {
  const Settled end = settled(box({0.06, 0.06, 0.06}), 0.2);
  EXPECT_LT(end.moved, 2e-4);
  EXPECT_LT(end.turned, 1e-3);
}

TEST(Settled, ALeaningPencilFalls) {
  // 7 x 7 x 180 mm leaning by 5 degrees: its centre of mass is 4 mm beyond its foot's edge.
  TriangleMesh pencil = geometry::transformed(
      box({0.007, 0.007, 0.18}),
      geometry::make_transform(Eigen::Quaterniond(Eigen::AngleAxisd(5 * std::numbers::pi / 180,
                                                                    Eigen::Vector3d::UnitY())),
                               {0, 0, 0}));
  const double bottom = geometry::bounds(pencil).min().z();
  for (Eigen::Vector3d& v : pencil.vertices) v.z() -= bottom;
  const Settled end = settled(pencil, 0.02);
  EXPECT_GT(end.moved, 0.08);  // its centre of mass falls from 90 mm to 3.5 mm
  EXPECT_NEAR(end.turned, 85 * std::numbers::pi / 180, 0.1);
}

TEST(Settled, WhatFloatsDropsAndWhatIsSunkIsRaised) {
  TriangleMesh floats = box({0.06, 0.06, 0.06}), sunk = floats;
  for (Eigen::Vector3d& v : floats.vertices) v.z() += 0.008;
  for (Eigen::Vector3d& v : sunk.vertices) v.z() -= 0.007;
  EXPECT_NEAR(settled(floats, 0.2).moved, 0.008, 5e-4);
  EXPECT_NEAR(settled(sunk, 0.2).moved, 0.007, 5e-4);
}

TEST(Settled, WhatStandsOnAnotherStaysThere) {
  TriangleMesh upper = box({0.06, 0.06, 0.06});
  for (Eigen::Vector3d& v : upper.vertices) v.z() += 0.05;
  EXPECT_LT(settled(upper, 0.2, {box({0.1, 0.1, 0.05})}).moved, 1e-3);
  EXPECT_GT(settled(upper, 0.2).moved, 0.045);
}

TEST(Settled, RefusesWhatHasNoVolume) {
  EXPECT_THROW(settled(TriangleMesh{}, 0.1), geometry::InputError);
}

// Once these fell over in the arms' world, where tables were as soft as the hands' rubber.
TEST(RestingPose, IsOneInTheWorldOfArmsAsWell) {
  const robot::Platform platform = robot::read_platform("config/robots/kr5_sdh.yaml");
  int tried = 0;
  for (const DataSet& set : make_data_sets("household", household_objects())) {
    if (set.name != "toy" && set.name != "spray_bottle_lying" && set.name != "mug") continue;
    SCOPED_TRACE(set.name);
    ++tried;
    const double mass = 0.2;
    const RigidTransform X_WB = resting_pose(*set.mesh_B, RigidTransform::Identity(), mass);
    simulation::RobotWorld world(platform, simulation::Scene(), "side");
    world.add_object("thing", geometry::transformed(*set.mesh_B, X_WB), mass);
    const RigidTransform X_before = world.body("thing").X_WB;
    for (int i = 0; i < 1500; ++i) world.step();
    const RigidTransform X_moved = world.body("thing").X_WB * X_before.inverse();
    EXPECT_LT(Eigen::AngleAxisd(X_moved.linear()).angle(), 0.01);
  }
  EXPECT_EQ(tried, 3);
}

}  // namespace
}  // namespace prehend::eval
