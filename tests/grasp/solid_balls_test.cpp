#include "prehend/grasp/closing/solid_balls.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <unistd.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/surface_samples.h"
#include "tests/grasp/hand_scene.h"
#include "tests/robot/as_meshes.h"

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

constexpr double kTolerance = 0.00025;  // m

double distance_to(const std::vector<SolidBall>& balls, const Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const SolidBall& ball : balls) {
    least = std::min(least, (p - ball.center).norm() - ball.radius);
  }
  return least;
}

TEST(SolidBalls, FacesOfABoxAreTrueAndItsEdgesRounded) {
  const Vector3d size(0.02, 0.03, 0.08);
  const std::vector<SolidBall> balls = balls_within(geometry::make_box(size), kTolerance);
  const double inset = ball_inset(0.02);
  EXPECT_NEAR(inset, 0.0036, 1e-12);
  std::mt19937_64 random(1);
  for (int i = 0; i < 600; ++i) {
    Vector3d p;
    const int face = i % 3;
    for (int k = 0; k < 3; ++k) p[k] = random_unit(random) * (size[k] / 2 - 1.5 * inset);
    p[face] = (i % 2 ? 1 : -1) * size[face] / 2;
    EXPECT_NEAR(distance_to(balls, p), 0, 1.2 * kTolerance) << p.transpose();
  }
  // A right edge rounded by r lies (sqrt(2) - 1) r beneath where it was.
  const double edge = distance_to(balls, {0.01, 0.015, 0});
  EXPECT_GT(edge, 0.2 * inset);
  EXPECT_LT(edge, 0.5 * inset);
  for (const SolidBall& ball : balls) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(std::abs(ball.center[k]) + ball.radius, size[k] / 2 + 1.1 * kTolerance);
    }
  }
  // About as many as a lattice of them would take.
  EXPECT_LT(balls.size(), 6000u);
}

// Balls of half the thickness; what is thinner than an inset is there too.
TEST(SolidBalls, ThinPlatesHollowsAndBallsAreTrue) {
  geometry::TriangleMesh cup = geometry::make_revolution(
      {{0.03, 0}, {0.03, 0.06}, {0.027, 0.06}, {0.027, 0.003}, {0.0, 0.003}}, 96);
  for (const geometry::TriangleMesh& solid :
       {geometry::make_box({0.002, 0.04, 0.05}), cup, geometry::make_sphere(0.02, 64)}) {
    const std::vector<SolidBall> balls = balls_within(solid, kTolerance);
    const geometry::MeshQuery query(solid);
    for (const SolidBall& ball : balls) {
      EXPECT_LE(query.signed_distance(ball.center) + ball.radius, 1.2 * kTolerance);
    }
    const double inset = ball_inset(query.box().sizes().minCoeff());
    double mean = 0;
    for (const geometry::SurfaceSample& sample : geometry::surface_samples(solid, 3000, 2)) {
      const double distance = distance_to(balls, sample.point);
      EXPECT_LE(distance, 0.5 * inset + kTolerance);  // at edges
      mean += std::abs(distance) / 3000;
    }
    EXPECT_LT(mean, 1.2 * kTolerance);
  }
  EXPECT_THROW(balls_within({}, kTolerance), geometry::InputError);
}

// A shelf's balls are over the floor beneath it, and do not hold it.
TEST(SolidBalls, WhatIsUnderALedgeIsHeld) {
  const auto at = [](const Vector3d& size, const Vector3d& p) {
    return moved(geometry::make_box(size), p);
  };
  const geometry::TriangleMesh solid = geometry::concatenated(
      {at({0.08, 0.08, 0.02}, {0, 0, 0}), at({0.08, 0.02, 0.046}, {0, 0.03, 0.013}),
       at({0.08, 0.08, 0.02}, {0, 0, 0.026})});
  const std::vector<SolidBall> balls = balls_within(solid, kTolerance);
  for (double x = -0.03; x < 0.031; x += 0.002) {
    for (double y = -0.03; y < 0.0115; y += 0.002) {
      for (const double z : {0.01, 0.016}) {
        EXPECT_NEAR(distance_to(balls, {x, y, z}), 0, 1.2 * kTolerance) << x << " " << y;
      }
    }
  }
}

// The hand of config/robots with its shapes written out as meshes closes as the hand does.
TEST(SolidBalls, AHandOfMeshesClosesAsOneOfBoxes) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("prehend_mesh_hand_" + std::to_string(getpid()));
  const TestHand boxes("sdh2");
  robot::write_with_meshes("schunk_sdh2.urdf", folder);
  std::filesystem::copy_file("config/robots/sdh2.yaml", folder / "sdh2.yaml");
  const robot::HandModel meshes = robot::read_hand_model(folder / "sdh2.yaml");
  std::filesystem::remove_all(folder);
  const HandToClose ready(meshes);
  for (const char* name : {"parallel", "spherical"}) {
    const robot::Preshape& preshape = meshes.preshape(name);
    const Vector3d tool = (meshes.X_HP * preshape.X_PG).translation();
    const TouchedMesh ball(moved(geometry::make_sphere(0.03, 64), tool));
    const ClosedFingers a = boxes.close(name, RigidTransform::Identity(), ball.scene);
    const ClosedFingers b =
        close_fingers(ready, RigidTransform::Identity(), preshape, preshape.open, ball.scene);
    ASSERT_EQ(a.finger_touches, b.finger_touches) << name;
    // Half a millimetre of both tolerances, 86 mm from the joint.
    EXPECT_LT((a.all - b.all).cwiseAbs().maxCoeff(), 0.012) << name;
    ASSERT_EQ(a.contacts.size(), b.contacts.size()) << name;
    for (std::size_t i = 0; i < a.contacts.size(); ++i) {
      EXPECT_EQ(a.contacts[i].link, b.contacts[i].link);
      EXPECT_EQ(a.contacts[i].pad, b.contacts[i].pad);
      EXPECT_LT((a.contacts[i].contact_W.point - b.contacts[i].contact_W.point).norm(), 0.002);
      EXPECT_GT(a.contacts[i].contact_W.normal.dot(b.contacts[i].contact_W.normal), 0.99);
    }
  }
}

}  // namespace
}  // namespace prehend::grasp
