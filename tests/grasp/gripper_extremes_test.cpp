// What is far from everyday, for a parallel gripper: sizes, meshes, frictions, what stands beside.

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "prehend/grasp/planner.h"
#include "tests/grasp/hand_scene.h"

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using geometry::TriangleMesh;

const robot::GripperModel kGripper;

/// Few candidates from above, so that tests are quick.
PlannerOptions few() {
  PlannerOptions options;
  options.generators = {"circles"};
  options.candidates.circles.rolls = 6;
  options.candidates.circles.standoffs = 3;
  options.uncertainty.samples = 4;
  return options;
}

Reachability along(const Vector3d& approach) {
  Reachability reachability;
  reachability.approach_W = approach;
  return reachability;
}

/// Plans on what stands on the table; every candidate must be accounted for and every grasp be one.
GraspPlan plan(const TriangleMesh& mesh, const PlannerOptions& options = few(),
               const Obstacles& obstacles = {}) {
  surface::ObjectModel object;
  object.mesh_W = moved(mesh, Vector3d(0, 0, -geometry::bounds(mesh).min().z()));
  const auto result = plan_grasps(object, geometry::Plane{}, obstacles, kGripper,
                                  along(-Vector3d::UnitZ()), options);
  int counted = static_cast<int>(result.grasps.size());
  for (const Rejection& rejection : result.rejections) counted += rejection.count;
  EXPECT_EQ(counted, result.candidates);
  EXPECT_EQ(result.grasps.empty(), !result.problem.empty());
  for (const Grasp& grasp : result.grasps) {
    EXPECT_TRUE(std::isfinite(grasp.score));
    EXPECT_GE(grasp.score, 0);
    EXPECT_GT(grasp.quality, 0);
    EXPECT_TRUE(grasp.X_WG.matrix().allFinite());
    EXPECT_GT(grasp.force, 0);
    EXPECT_LE(pregrasp_opening(grasp), kGripper.max_opening);
  }
  return result;
}

TEST(GripperExtremes, SizesFromASpeckToAWardrobe) {
  EXPECT_TRUE(plan(geometry::make_box({1.0, 0.6, 2.0})).grasps.empty());
  EXPECT_TRUE(plan(geometry::make_box({0.002, 0.002, 0.002})).grasps.empty());
  EXPECT_TRUE(plan(geometry::make_box({0.3, 0.3, 0.001})).grasps.empty());  // a plate that lies
  const auto plate = plan(geometry::make_box({0.12, 0.004, 0.12}));         // one that stands
  ASSERT_FALSE(plate.grasps.empty()) << plate.problem;
  EXPECT_GT(std::abs(plate.grasps.front().X_WG.linear().col(1).y()), 0.99);
  EXPECT_NEAR(plate.grasps.front().predicted.opening, 0.004, 1e-3);
  plan(geometry::make_revolution({{0.0005, 0}, {0.0005, 0.15}}, 8));  // a needle that stands
}

TEST(GripperExtremes, RoundAndHollow) {
  EXPECT_FALSE(plan(geometry::make_sphere(0.03)).grasps.empty());
  // A ring that stands is held across its tube.
  RigidTransform upright = RigidTransform::Identity();
  upright.linear() = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX()).toRotationMatrix();
  const auto ring = plan(moved(make_torus(0.05, 0.015, 48, 24), upright));
  ASSERT_FALSE(ring.grasps.empty()) << ring.problem;
  EXPECT_LT(ring.grasps.front().predicted.opening, 0.032);
}

TEST(GripperExtremes, AFewThousandTrianglesOrAMillionAreOneBall) {
  const auto coarse = plan(geometry::make_sphere(0.03, 64));
  PlannerOptions options = few();
  options.uncertainty.samples = 1;
  const TriangleMesh fine = geometry::make_sphere(0.03, 1000);
  ASSERT_GT(fine.triangles.size(), 900000u);
  const auto many = plan(fine, options);
  ASSERT_FALSE(coarse.grasps.empty());
  ASSERT_FALSE(many.grasps.empty()) << many.problem;
  EXPECT_NEAR(many.grasps.front().predicted.opening, coarse.grasps.front().predicted.opening, 1e-3);
  EXPECT_NEAR(many.grasps.front().predicted.lifted_mass,
              coarse.grasps.front().predicted.lifted_mass,
              0.02 * coarse.grasps.front().predicted.lifted_mass);
}

TEST(GripperExtremes, DegenerateTrianglesChangeNothing) {
  TriangleMesh box = geometry::make_box({0.04, 0.05, 0.1});
  const auto clean = plan(box);
  box.triangles.emplace_back(2, 2, 2);
  box.triangles.emplace_back(0, 0, 1);
  const auto odd = plan(box);
  ASSERT_FALSE(clean.grasps.empty());
  ASSERT_EQ(odd.grasps.size(), clean.grasps.size());
  EXPECT_NEAR(odd.grasps.front().score, clean.grasps.front().score, 1e-9);
}

TEST(GripperExtremes, FrictionOfNearlyNoneAndOfTwo) {
  const TriangleMesh carton = geometry::make_box({0.04, 0.05, 0.1});
  PlannerOptions options = few();
  options.pads.friction = options.uncertainty.least_friction =
      options.uncertainty.largest_friction = 1e-6;
  const auto none = plan(carton, options);
  EXPECT_TRUE(none.grasps.empty());
  options.pads.friction = 0;
  EXPECT_THROW(plan(carton, options), std::invalid_argument);
  options.pads.friction = options.uncertainty.largest_friction = 2;
  const auto rough = plan(carton, options);
  const auto usual = plan(carton);
  ASSERT_FALSE(rough.grasps.empty());
  EXPECT_GE(rough.grasps.size(), usual.grasps.size());
  EXPECT_LE(rough.grasps.front().force, usual.grasps.front().force);
}

TEST(GripperExtremes, TouchingANeighbourOrFiveMillimetresFromIt) {
  const TriangleMesh carton = geometry::make_box({0.04, 0.05, 0.1});
  for (const double gap : {0.0, 0.005}) {
    Obstacles beside;
    beside.meshes_W.push_back(
        moved(geometry::make_box({0.06, 0.4, 0.09}), Vector3d(0.02 + gap + 0.03, 0, 0.045)));
    const auto result = plan(carton, few(), beside);
    ASSERT_FALSE(result.grasps.empty()) << gap << ": " << result.problem;
    for (const Grasp& grasp : result.grasps) {
      // The fingers have no room between, unless above the neighbour: they close along it.
      EXPECT_GT(std::abs(grasp.X_WG.linear().col(1).y()), 0.9) << gap;
    }
  }
}

TEST(GripperExtremes, AtAWallThatTheHousingDoesNotPassIsToldSo) {
  Obstacles wall;
  wall.meshes_W.push_back(moved(geometry::make_box({0.02, 0.4, 0.4}), Vector3d(0.03, 0, 0.2)));
  const auto result = plan(geometry::make_box({0.04, 0.05, 0.1}), few(), wall);
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_NE(result.problem.find("hand would hit another object"), std::string::npos)
      << result.problem;
}

TEST(GripperExtremes, AMovedAndTiltedTableMovesTheGrasps) {
  const TriangleMesh mesh = moved(geometry::make_box({0.04, 0.05, 0.1}), Vector3d(0.01, 0, 0.05));
  surface::ObjectModel object;
  object.mesh_W = mesh;
  const auto level =
      plan_grasps(object, geometry::Plane{}, {}, kGripper, along(-Vector3d::UnitZ()), few());
  ASSERT_FALSE(level.grasps.empty());
  const RigidTransform X_VW = geometry::make_transform(
      Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vector3d(1, 2, 0.3).normalized())),
      Vector3d(3, -2, 1));
  object.mesh_W = moved(mesh, X_VW);
  const Vector3d up = X_VW.linear() * Vector3d::UnitZ();
  const geometry::Plane tilted{up, up.dot(X_VW.translation())};
  const auto result = plan_grasps(object, tilted, {}, kGripper, along(-up), few());
  ASSERT_EQ(result.grasps.size(), level.grasps.size());
  EXPECT_EQ(result.candidates, level.candidates);
  EXPECT_NEAR(result.grasps.front().score, level.grasps.front().score, 0.01);
  EXPECT_NEAR(result.grasps.front().predicted.opening, level.grasps.front().predicted.opening,
              1e-4);
}

}  // namespace
}  // namespace prehend::grasp
