#include "prehend/grasp/closing/collision.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"

namespace prehend::grasp {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;

const robot::GripperModel kCollisionGripper;

TriangleMesh box_at(const Eigen::Vector3d& size, const Eigen::Vector3d& p) {
  return geometry::transformed(geometry::make_box(size),
                               geometry::make_transform(Eigen::Quaterniond::Identity(), p));
}

// The hand from above, pads' centre at `p`, closing along world y.
RigidTransform from_above(const Eigen::Vector3d& p) {
  return geometry::make_transform(Eigen::Quaterniond(0, 1, 0, 0), p);
}

TEST(Collision, TableClearanceIsThatOfTheFingertips) {
  const CollisionScene scene(nullptr, geometry::Plane{}, {});
  const auto hand = swept_hand(kCollisionGripper, 0.069, 0.1);
  EXPECT_NEAR(scene.table_clearance(hand, from_above({0, 0, 0.1})), 0.1 - kCollisionGripper.tip_z(),
              1e-12);
  EXPECT_EQ(scene.check(hand, from_above({0, 0, 0.1})), HandCollision::kNone);
  EXPECT_EQ(scene.check(hand, from_above({0, 0, kCollisionGripper.tip_z() + 0.0039})),
            HandCollision::kTable);
  EXPECT_EQ(scene.check(hand, from_above({0, 0, kCollisionGripper.tip_z() + 0.0041})),
            HandCollision::kNone);
}

TEST(Collision, OpenFingersStraddleWhatFitsBetweenThem) {
  const auto hand = swept_hand(kCollisionGripper, 0.069, 0.1);
  const geometry::Plane table;
  const RigidTransform X_WG = from_above({0, 0, 0.05});
  // Margin 1.5 mm at each side: 66 mm is the limit.
  const geometry::MeshQuery fits(box_at({0.05, 0.0658, 0.05}, {0, 0, 0.025})),
      is_too_wide(box_at({0.05, 0.0662, 0.05}, {0, 0, 0.025}));
  EXPECT_EQ(CollisionScene(&fits, table, {}).check(hand, X_WG), HandCollision::kNone);
  EXPECT_EQ(CollisionScene(&is_too_wide, table, {}).check(hand, X_WG), HandCollision::kObject);
}

TEST(Collision, TheWayFromThePregraspIsSwept) {
  const auto still = swept_hand(kCollisionGripper, 0.069, 0);
  const auto swept = swept_hand(kCollisionGripper, 0.069, 0.2);
  // A board over the housing: only the way down from the pregrasp meets it.
  Obstacles obstacles;
  obstacles.meshes_W.push_back(box_at({0.3, 0.3, 0.01}, {0, 0, 0.3}));
  const CollisionScene scene(nullptr, geometry::Plane{}, obstacles);
  EXPECT_EQ(scene.check(still, from_above({0, 0, 0.05})), HandCollision::kNone);
  EXPECT_EQ(scene.check(swept, from_above({0, 0, 0.05})), HandCollision::kObstacle);
}

TEST(Collision, ObstacleCloudsAndMeshesAgree) {
  const TriangleMesh neighbour = box_at({0.03, 0.03, 0.1}, {0, 0.065, 0.05});
  Obstacles as_mesh, as_cloud;
  as_mesh.meshes_W.push_back(neighbour);
  for (int i = 0; i <= 10; ++i) {
    for (int k = 0; k <= 20; ++k) {
      as_cloud.cloud_W.points.emplace_back(-0.015f + 0.003f * static_cast<float>(i), 0.05f,
                                           0.005f * static_cast<float>(k));
    }
  }
  const float nan = std::numeric_limits<float>::quiet_NaN();
  as_cloud.cloud_W.points.emplace_back(nan, nan, nan);
  const CollisionScene mesh_scene(nullptr, geometry::Plane{}, as_mesh);
  const CollisionScene cloud_scene(nullptr, geometry::Plane{}, as_cloud);
  for (double opening : {0.02, 0.04, 0.05, 0.065, 0.069}) {
    // Finger's back at opening/2 + 12 mm, margin 5 mm, obstacle's face at 50 mm.
    const bool expected = opening / 2 + 0.012 + 0.005 > 0.05;
    const auto hand = swept_hand(kCollisionGripper, opening, 0.0);
    const RigidTransform X_WG = from_above({0, 0, 0.06});
    EXPECT_EQ(mesh_scene.check(hand, X_WG) == HandCollision::kObstacle, expected) << opening;
    EXPECT_EQ(cloud_scene.check(hand, X_WG) == HandCollision::kObstacle, expected) << opening;
  }
}

// An obstacle is made ready when the hand comes near it; an object always is.
TEST(Collision, AnObstacleIsMetWhereTheSameThingAsObjectIs) {
  CollisionOptions options;
  options.obstacle_margin = options.object_margin;
  const TriangleMesh ball = geometry::transformed(
      geometry::make_sphere(0.03, 24),
      geometry::make_transform(Eigen::Quaterniond::Identity(), {0.2, 0.1, 0.15}));
  const geometry::Plane far_below{Eigen::Vector3d::UnitZ(), -2};
  const geometry::MeshQuery ball_W(ball);
  const CollisionScene as_object(&ball_W, far_below, {}, options);
  const CollisionScene as_obstacle(nullptr, far_below,
                                   {{box_at({0.1, 0.1, 0.1}, {5, 5, 5}), ball}, {}}, options);
  const auto hand = swept_hand(kCollisionGripper, 0.05, 0.1);
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  int met = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(unit(random), unit(random), unit(random), unit(random)).normalized();
    const Eigen::Vector3d p = Eigen::Vector3d(0.2, 0.1, 0.15) +
                              0.12 * Eigen::Vector3d(unit(random), unit(random), unit(random));
    const RigidTransform X_WG = geometry::make_transform(turn, p);
    const bool expected = as_object.check(hand, X_WG) == HandCollision::kObject;
    met += expected;
    ASSERT_EQ(as_obstacle.check(hand, X_WG) == HandCollision::kObstacle, expected) << i;
  }
  EXPECT_GT(met, 200);
  EXPECT_LT(met, 1800);
}

TEST(Collision, SwallowedHandIsNoticed) {
  const geometry::MeshQuery block(box_at({10, 10, 10}, {0, 0, 5}));
  const CollisionScene scene(&block, geometry::Plane{}, {});
  EXPECT_EQ(scene.check(swept_hand(kCollisionGripper, 0.069, 0.1), from_above({0, 0, 4})),
            HandCollision::kObject);
}

TEST(Collision, RejectsBrokenMeshes) {
  TriangleMesh broken = geometry::make_box({1, 1, 1});
  broken.vertices[0].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(CollisionScene(nullptr, geometry::Plane{}, {{broken}, {}}), geometry::InputError);
}

}  // namespace
}  // namespace prehend::grasp
