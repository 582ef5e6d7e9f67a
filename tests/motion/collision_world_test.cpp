#include "prehend/motion/robot_in_world.h"

#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/motion/fcl_oracle.h"
#include "tests/robot/arms.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using ::testing::HasSubstr;

Vector3d random_point(std::mt19937_64& random, double size) {
  const auto next = [&] { return size * (2 * robot::uniform(random) - 1); };
  const double x = next(), y = next();
  return {x, y, next()};
}

RigidTransform random_pose(std::mt19937_64& random, double size) {
  const Vector3d axis = random_point(random, 1);
  return geometry::make_transform(
      Eigen::Quaterniond(Eigen::AngleAxisd(3 * robot::uniform(random), axis.normalized())),
      random_point(random, size));
}

TEST(RobotSpheres, HoldEveryShape) {
  const robot::RobotModel model = robot::read_urdf("config/robots/kr5_sixx_r850.urdf");
  const robot::KinematicChain chain = robot::kr5();
  std::mt19937_64 random(1);
  for (const double resolution : {0.02, 0.06, 0.2}) {
    const RobotSpheres spheres = make_robot_spheres(model, "base_link", "tool0", resolution);
    std::vector<Vector3d> centers;
    std::vector<RigidTransform> poses;
    const robot::Positions q = robot::random_positions(chain, random);
    spheres.centers(chain, q, centers);
    chain.forward(q, poses);
    for (const FclOracle::Part& part : FclOracle(model, chain).parts) {
      // Random points of the shape's bounds that are in the shape.
      for (int n = 0; n < 2000; ++n) {
        part.shape->computeLocalAABB();
        const Vector3d half = 0.5 * (part.shape->aabb_local.max_ - part.shape->aabb_local.min_);
        const Vector3d p = random_point(random, 1).cwiseProduct(half);
        const auto* cylinder = dynamic_cast<const fcl::Cylinder<double>*>(part.shape.get());
        if (cylinder && p.head<2>().norm() > cylinder->radius) continue;
        const auto* ball = dynamic_cast<const fcl::Sphere<double>*>(part.shape.get());
        if (ball && p.norm() > ball->radius) continue;
        const Vector3d p_B = poses[static_cast<std::size_t>(part.joint)] * (part.X_JS * p);
        bool held = false;
        for (std::size_t i = 0; i < centers.size() && !held; ++i) {
          held = (centers[i] - p_B).norm() <= spheres.spheres[i].radius - kBallSpare + 1e-9;
        }
        ASSERT_TRUE(held) << resolution;
      }
    }
  }
  EXPECT_THROW(make_robot_spheres(model, "base_link", "tool0", 0), std::invalid_argument);
}

TEST(CollisionWorld, BoxesAndSpheresAreExact) {
  std::mt19937_64 random(2);
  for (int n = 0; n < 500; ++n) {
    CollisionWorld world;
    const RigidTransform X = random_pose(random, 0.3);
    const Vector3d size = Vector3d(0.05, 0.05, 0.05) + 0.2 * random_point(random, 1).cwiseAbs();
    if (n % 2 == 0) {
      world.add_box("o", X, size);
    } else {
      world.add_sphere("o", X.translation(), size.x());
    }
    const Vector3d center = random_point(random, 0.6);
    const double radius = 0.02 + 0.1 * robot::uniform(random);
    const FclOracle::Object ball(std::make_shared<fcl::Sphere<double>>(radius),
                                 RigidTransform(Eigen::Translation3d(center)));
    const FclOracle::Object obstacle =
        n % 2 == 0 ? FclOracle::Object(std::make_shared<fcl::Box<double>>(size), X)
                   : FclOracle::Object(std::make_shared<fcl::Sphere<double>>(size.x()), X);
    fcl::DistanceRequest<double> request;
    fcl::DistanceResult<double> result;
    const double distance = fcl::distance(&ball, &obstacle, request, result);
    const double ours = world.clearance(center, radius);
    if (distance > 1e-6) {
      EXPECT_NEAR(ours, distance, 1e-5);
    } else {
      EXPECT_LT(ours, 1e-5);
    }
    EXPECT_EQ(world.touches(center, radius, 0.01), ours < 0.01);
  }
}

TEST(CollisionWorld, ConvexPiecesAreNeverFartherThanTheyAre) {
  // A box as a convex piece: as far beside its faces, nearer beside its edges.
  const Vector3d size(0.1, 0.2, 0.3);
  CollisionWorld exact, convex;
  exact.add_box("o", RigidTransform::Identity(), size);
  convex.add_convex("o", geometry::make_box(size));
  std::mt19937_64 random(3);
  for (int n = 0; n < 2000; ++n) {
    const Vector3d p = random_point(random, 0.4);
    const double a = exact.clearance(p, 0.03), b = convex.clearance(p, 0.03);
    EXPECT_LE(b, a + 1e-7);  // the hull is made in single precision
    if (a > -0.03) {
      EXPECT_GE(b, (a + 0.03) / std::sqrt(3.0) - 0.03 - 1e-7);
    }
  }
  EXPECT_NEAR(convex.clearance({0.2, 0, 0}, 0.03), 0.12, 1e-7);
  EXPECT_THROW(convex.add_convex("empty", {}), geometry::InputError);
}

TEST(CollisionWorld, NamesRemovesAndRefuses) {
  CollisionWorld world;
  EXPECT_EQ(world.clearance({0, 0, 0}, 1), std::numeric_limits<double>::infinity());
  world.add_plane("table", {Vector3d::UnitZ(), 0.1});
  world.add_sphere("ball", {0, 0, 1}, 0.2);
  std::string nearest;
  EXPECT_NEAR(world.clearance({0, 0, 0.3}, 0.05, &nearest), 0.15, 1e-12);
  EXPECT_EQ(nearest, "table");
  EXPECT_TRUE(world.remove("table"));
  EXPECT_FALSE(world.remove("table"));
  world.clearance({0, 0, 0.3}, 0.05, &nearest);
  EXPECT_EQ(nearest, "ball");
  EXPECT_THROW(world.add_sphere("s", {0, 0, 0}, 0), std::invalid_argument);
  EXPECT_THROW(world.add_box("b", RigidTransform::Identity(), {1, 0, 1}), std::invalid_argument);
}

RobotInWorld pa10_over_table() {
  const robot::RobotModel model = robot::read_urdf("config/robots/pa10_7c.urdf");
  CollisionWorld world;
  world.add_plane("table", {Vector3d::UnitZ(), -0.02});
  return {robot::pa10(), make_robot_spheres(model, "base_link", "tool0"), world};
}

TEST(RobotInWorld, SaysWhatTouchesWhat) {
  RobotInWorld robot = pa10_over_table();
  robot::Positions q = robot::Positions::Zero(7);
  EXPECT_EQ(robot.problem(q), "");
  q[1] = 1.5;
  q[3] = 1.2;  // over and down to the table
  EXPECT_THAT(robot.problem(q), HasSubstr("touches 'table'"));
  q = robot::Positions::Zero(7);
  q[5] = 2.8;  // the flange folded onto the forearm
  EXPECT_EQ(robot.problem(q), "the link of joint 'e2' touches the link of joint 'w2'");
  q[5] = 0;
  q[3] = 2.39;  // and a long tool onto the base
  EXPECT_TRUE(robot.is_free(q));
  robot.change_world([&](CollisionWorld& world) { world.remove("table"); });
  robot.attach({{0, {0, 0, 0.3}, 0.55}});
  EXPECT_THAT(robot.problem(q), HasSubstr("touches what is held"));
  robot.detach();
  q[3] = 3;
  EXPECT_THAT(robot.problem(q), HasSubstr("beyond"));
  // What is held counts.
  q = robot::Positions::Zero(7);
  robot.change_world([&](CollisionWorld& world) { world.add_sphere("lamp", {0, 0, 1.9}, 0.1); });
  EXPECT_TRUE(robot.is_free(q));
  robot.attach({{0, {0, 0, 0.4}, 0.06}});
  EXPECT_THAT(robot.problem(q), HasSubstr("what is held touches 'lamp'"));
  robot.detach();
  EXPECT_TRUE(robot.is_free(q));
}

TEST(RobotInWorld, NeverMissesWhatFclFinds) {
  const robot::RobotModel model = robot::read_urdf("config/robots/pa10_7c.urdf");
  const robot::KinematicChain chain = robot::pa10();
  std::mt19937_64 random(4);
  CollisionWorld world;
  FclOracle oracle(model, chain);
  for (int i = 0; i < 30; ++i) {
    const RigidTransform X = random_pose(random, 0.8);
    const Vector3d size = Vector3d(0.05, 0.05, 0.05) + 0.15 * random_point(random, 1).cwiseAbs();
    world.add_box("b", X, size);
    oracle.add_box(X, size);
    world.add_sphere("s", X * Vector3d(0.4, 0, 0), 0.08);
    oracle.add_sphere(X * Vector3d(0.4, 0, 0), 0.08);
  }
  const RobotInWorld robot(chain, make_robot_spheres(model, "base_link", "tool0", 0.04), world, 0);
  int hit = 0, both = 0;
  for (int n = 0; n < 2000; ++n) {
    const robot::Positions q = robot::random_positions(chain, random);
    const std::string problem = robot.problem(q);
    const bool ours = problem.find("touches 'b'") != std::string::npos ||
                      problem.find("touches 's'") != std::string::npos;
    const bool theirs = oracle.collides(chain, q);
    hit += theirs;
    both += ours && theirs;
    ASSERT_TRUE(!theirs || !problem.empty()) << n;
  }
  EXPECT_GT(hit, 200);
  EXPECT_LT(hit, 1900);
}

}  // namespace
}  // namespace prehend::motion
