// The camera that an arm carries is brought to where it sees what nobody has seen.

#include "prehend/planning/camera_look.h"

#include <cmath>
#include <stdexcept>

#include <gmock/gmock.h>

#include "prehend/motion/checker_registry.h"
#include "prehend/surface/model.h"

namespace prehend::planning {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using ::testing::HasSubstr;

constexpr double kHeight = 0.12;  // m
const geometry::StereoCamera kCamera{{1024, 768, 1100, 1100, 511.5, 383.5}, 0.09};

geometry::TriangleMesh standing_box(const Vector3d& size, const Vector3d& p_W = Vector3d::Zero()) {
  return geometry::transformed(
      geometry::make_box(size),
      geometry::make_transform(Eigen::Quaterniond::Identity(), p_W + Vector3d(0, 0, size.z() / 2)));
}

geometry::TriangleMesh standing_can() {
  constexpr double kRadius = 0.03;
  return geometry::make_revolution(
      {{0, 0}, {kRadius, 0}, {kRadius, 0.5 * kHeight}, {kRadius, kHeight}, {0, kHeight}});
}

/// A can of which the camera at home has seen what faces it; its far side may be deeper.
surface::ObjectModel seen_can(const robot::Platform& platform, double deeper) {
  surface::ObjectModel object = surface::model_of_mesh(standing_can());
  object.vertex_origin.clear();
  const Vector3d eye = platform.X_WC(platform.home("home").arm).translation();
  for (const Vector3d& p : object.mesh_W.vertices) {
    const Vector3d out(p.x(), p.y(), 0);
    const bool seen = p.z() > 0.9 * kHeight || (p.z() > 0 && out.dot(eye - p) > 0);
    object.vertex_origin.push_back(seen ? surface::SurfaceOrigin::kSeen
                                        : surface::SurfaceOrigin::kPredicted);
  }
  geometry::TriangleMesh other = standing_can();
  for (Vector3d& p : other.vertices) {
    if (p.x() > 0) p.x() *= (0.03 + deeper) / 0.03;
  }
  object.alternatives_W.push_back(std::move(other));
  object.shape_weights = {0.6, 0.4};
  return object;
}

class CameraLook : public testing::Test {
 protected:
  PlannedLook plan(const surface::ObjectModel& object,
                   const std::vector<geometry::TriangleMesh>& others = {},
                   ViewOptions options = {}) const {
    options.budget = 0;
    return plan_look(platform_, platform_.home("home").arm, kCamera, object,
                     {geometry::Plane(), object.convex_pieces_W, others}, {}, options);
  }

  const robot::Platform platform_ = robot::read_platform("config/robots/kr5_sdh_camera.yaml");
};

// All by the platform's own kinematics and the can's: nothing of the planner's.
TEST_F(CameraLook, EndsWhereANewSideIsSeenAllInThePicture) {
  const surface::ObjectModel object = seen_can(platform_, 0.03);
  const PlannedLook look = plan(object);
  ASSERT_TRUE(look.found()) << look.problem;
  EXPECT_GT(look.gain, 0.1);
  const motion::BlendedTrajectory& way = *look.trajectory;
  EXPECT_LT((way.at(0).position - platform_.home("home").arm).norm(), 1e-6);
  const RigidTransform X_WC = platform_.X_WC(way.at(way.duration()).position);
  EXPECT_LT((X_WC.matrix() - look.X_WC.matrix()).norm(), 1e-5);
  for (const Vector3d& p_W : object.mesh_W.vertices) {
    const Vector3d p_C = X_WC.inverse() * p_W;
    EXPECT_GT(p_C.z(), ViewOptions().nearest - 0.01);
    for (const double x : {0.0, kCamera.baseline}) {
      const Eigen::Vector2d pixel = kCamera.left.project(p_C - x * Vector3d::UnitX());
      EXPECT_GT(pixel.x(), 0);
      EXPECT_LT(pixel.x(), kCamera.left.width);
      EXPECT_GT(pixel.y(), 0);
      EXPECT_LT(pixel.y(), kCamera.left.height);
    }
  }
  // From another side than before, round the can's axis.
  const Eigen::Vector2d before =
      platform_.X_WC(platform_.home("home").arm).translation().head<2>().normalized();
  const Vector3d eye = X_WC.translation();
  EXPECT_LT(before.dot(eye.head<2>().normalized()), std::cos(0.7)) << eye.transpose();
  EXPECT_GT(eye.z(), kHeight);
}

// The arm goes there and back through neither the can nor its neighbour.
TEST_F(CameraLook, TheWayIsFree) {
  const surface::ObjectModel object = seen_can(platform_, 0.03);
  const std::vector<geometry::TriangleMesh> others{
      standing_box({0.06, 0.06, 0.35}, {0.02, 0.2, 0})};
  const PlannedLook look = plan(object, others);
  ASSERT_TRUE(look.found()) << look.problem;
  const PlatformScene scene{geometry::Plane(), object.convex_pieces_W, others};
  const motion::RobotInWorld robot =
      robot_in(world_of(platform_, scene), platform_, platform_.hand.preshapes.front().open, 0,
               0.04, motion::CheckerRegistry().create("fcl"));
  for (int i = 0; i <= 200; ++i) {
    EXPECT_TRUE(robot.is_free(look.trajectory->at(look.trajectory->duration() * i / 200).position))
        << i;
  }
}

TEST_F(CameraLook, SaysHowFarItShowsTheShapesApart) {
  constexpr double kDeeper = 0.03;
  const PlannedLook look = plan(seen_can(platform_, kDeeper));
  ASSERT_TRUE(look.found()) << look.problem;
  ASSERT_EQ(look.apart.rows(), 2);
  ASSERT_EQ(look.apart.cols(), 2);
  EXPECT_EQ(look.apart.diagonal().norm(), 0);
  for (const double apart : {look.apart(0, 1), look.apart(1, 0)}) {
    EXPECT_GT(apart, 0.1 * kDeeper);
    EXPECT_LT(apart, kDeeper) << "no part of it is farther off than that";
  }
  surface::ObjectModel alike = seen_can(platform_, kDeeper);
  alike.alternatives_W = {alike.mesh_W};
  EXPECT_LT(plan(alike).apart.norm(), 1e-9);
}

TEST_F(CameraLook, WhyThereIsNoneIsSaid) {
  surface::ObjectModel known = seen_can(platform_, 0.03);
  known.vertex_origin.assign(known.vertex_origin.size(), surface::SurfaceOrigin::kSeen);
  const PlannedLook nothing_new = plan(known);
  EXPECT_FALSE(nothing_new.found());
  EXPECT_THAT(nothing_new.problem, HasSubstr("no side of it that a camera sees would be new"));
  ViewOptions far;
  far.nearest = 3;
  const PlannedLook out_of_reach = plan(seen_can(platform_, 0.03), {}, far);
  EXPECT_FALSE(out_of_reach.found());
  EXPECT_THAT(out_of_reach.problem, HasSubstr("the arm cannot bring the camera"));
}

TEST_F(CameraLook, RefusesWhatMakesNoSense) {
  const surface::ObjectModel object = seen_can(platform_, 0.03);
  const PlatformScene scene{geometry::Plane(), object.convex_pieces_W, {}};
  const robot::Platform without = robot::read_platform("config/robots/kr5_sdh.yaml");
  EXPECT_THROW(plan_look(without, without.home("home").arm, kCamera, object, scene, {}),
               std::invalid_argument);
  EXPECT_THROW(plan_look(platform_, robot::Positions::Zero(3), kCamera, object, scene, {}),
               std::invalid_argument);
  EXPECT_THROW(plan_look(platform_, platform_.home("home").arm, {}, object, scene, {}),
               std::invalid_argument);
  ViewOptions steep;
  steep.steepest = std::nan("");
  EXPECT_THROW(plan_look(platform_, platform_.home("home").arm, kCamera, object, scene, {}, steep),
               std::invalid_argument);
}

}  // namespace
}  // namespace prehend::planning
