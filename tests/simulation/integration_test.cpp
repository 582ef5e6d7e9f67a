// First and second order: closed forms and observed orders.

#include <cmath>

#include <gtest/gtest.h>

#include "grasping.h"

namespace prehend::simulation {
namespace {

using contact::Integration;
using testing::above;
using testing::grasp;
using testing::grasp_scene;
using testing::height_of;
using testing::kGraspHeight;
using testing::run;

Scene cube_scene(Integration integration, double step) {
  Scene scene;
  scene.step = step;
  scene.physics.integration = integration;
  scene.physics.rules.out_of_reach = false;
  SceneObject cube;
  cube.name = "cube";
  cube.size.setConstant(0.1);
  cube.mass = 20;
  scene.objects.push_back(cube);
  return scene;
}

geometry::RigidTransform at_height(double z) {
  return geometry::make_transform(Eigen::Quaterniond::Identity(), {0, 0, z});
}

TEST(Integration, FreeFallIsExactInSecondOrder) {
  World world(cube_scene(Integration::kSecondOrder, 0.01));
  world.place_object("cube", at_height(0.5));
  run(world, 0.2);
  EXPECT_NEAR(world.body("cube").X_WB.translation().z(), 0.5 - 0.5 * 9.81 * 0.04, 1e-12);
  EXPECT_NEAR(world.body("cube").velocity.z(), -9.81 * 0.2, 1e-12);
}

// On the table's springs the cube is a damped oscillator round its static depth m g / k:
// z = -mg/k + exp(-d t) (A cos w t + B sin w t), from z = -1 um at rest.
TEST(Integration, SettlingOnTheTableIsADampedOscillation) {
  const double m = 20, k = 4 * 1e5, c = 4 * 200, start = -1e-6, t = 0.02;
  const double rest = -m * 9.81 / k, decay = c / (2 * m), w = std::sqrt(k / m - decay * decay);
  const double A = start - rest, B = decay * A / w;
  const double expected = rest + std::exp(-decay * t) * (A * std::cos(w * t) + B * std::sin(w * t));
  const auto error = [&](Integration integration, double step) {
    World world(cube_scene(integration, step));
    world.place_object("cube", at_height(start));
    run(world, t);
    return std::abs(world.body("cube").height - expected);
  };
  const auto order = [&](Integration integration) {
    return std::log2(error(integration, 5e-4) / error(integration, 2.5e-4));
  };
  EXPECT_GT(order(Integration::kFirstOrder), 0.9);
  EXPECT_GT(order(Integration::kSecondOrder), 1.8);
  EXPECT_LT(error(Integration::kSecondOrder, 2.5e-4), 1e-3 * A);
}

// A box with unlike moments tumbles freely: its angular momentum stays.
TEST(Integration, TumblingKeepsItsAngularMomentum) {
  const auto turned = [](Integration integration, double step) {
    Scene scene = cube_scene(integration, step);
    scene.gravity = 0;
    scene.objects[0].size = {0.04, 0.08, 0.15};
    World world(scene);
    // Set spinning by the table's springs under one edge.
    world.place_object("cube",
                       geometry::make_transform(Eigen::Quaterniond(Eigen::AngleAxisd(
                                                    0.4, Eigen::Vector3d(1, 0.3, 0).normalized())),
                                                {0, 0, -0.001}));
    run(world, 0.5);
    return world;
  };
  for (const auto integration : {Integration::kFirstOrder, Integration::kSecondOrder}) {
    World world = turned(integration, 1e-3);
    const BodyReading before = world.body("cube");
    ASSERT_GT(before.angular_velocity.norm(), 0.1);
    ASSERT_GT(before.height, 0);
    const Eigen::Vector3d size(0.04, 0.08, 0.15);
    const Eigen::Matrix3d inertia = contact::box_inertia(20, size);
    const auto momentum = [&](const BodyReading& body) {
      const Eigen::Matrix3d R = body.X_WB.linear();
      return Eigen::Vector3d(R * inertia * R.transpose() * body.angular_velocity);
    };
    const Eigen::Vector3d L = momentum(before);
    run(world, 1);
    EXPECT_LT((momentum(world.body("cube")) - L).norm(), 1e-8 * L.norm());
  }
}

// Two boxes that stand in one another fly apart, turning; the pair has no momentum before or after.
// Linear momentum is kept to the rounding of the linear system, whatever the iterations leave:
// every contact adds the same number to both bodies' rows. So is angular momentum in first order,
// since p x v does not change along v; SDIRK2 keeps no quadratic invariants and loses some in an
// impact.
TEST(Integration, AFreePairKeepsItsMomenta) {
  for (const auto integration : {Integration::kFirstOrder, Integration::kSecondOrder}) {
    for (const double step : {1e-4, 1e-3, 1e-2}) {
      SCOPED_TRACE(step);
      const bool first_order = integration == Integration::kFirstOrder;
      Scene scene = cube_scene(integration, step);
      scene.gravity = 0;
      scene.objects[0].size.setConstant(0.05);
      scene.objects[0].mass = 0.3;
      scene.objects.push_back(scene.objects[0]);
      scene.objects[1].name = "other";
      scene.objects[1].mass = 0.05;
      World world(scene);
      const Eigen::Quaterniond aslant(
          Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 3).normalized()));
      world.place_object("cube", geometry::make_transform(aslant, {0, 0, 0.3}));
      world.place_object(
          "other", geometry::make_transform(Eigen::Quaterniond::Identity(), {0.045, 0.01, 0.305}));
      double most = 0;  // kg m/s, of either
      for (int i = 0; i < std::lround(0.3 / step); ++i) {
        world.step();
        Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
        for (const char* name : {"cube", "other"}) {
          const BodyReading body = world.body(name);
          const Eigen::Vector3d center = body.X_WB * Eigen::Vector3d(0, 0, 0.025);
          linear += body.mass * body.velocity;
          angular += body.mass * (0.05 * 0.05 / 6 * body.angular_velocity +
                                  (center - Eigen::Vector3d(0, 0, 0.3)).cross(body.velocity));
        }
        const double each = 0.05 * world.body("other").velocity.norm();
        most = std::max({most, each, step * 500});  // 500 N: one point's spring at the start
        ASSERT_LE(linear.norm(), 1e-12 * most) << i;
        ASSERT_LE(angular.norm(), (first_order ? 1e-12 : 0.02) * 0.05 * most) << i;
      }
      EXPECT_GT(world.body("other").velocity.norm(), 0.1) << "they do part";
      EXPECT_GT(world.body("other").angular_velocity.norm(), 5) << "and turn";
    }
  }
}

TEST(Integration, SecondOrderHoldsWhatItGrasps) {
  for (const double step : {1e-3, 5e-3}) {
    Scene scene = grasp_scene(0.35, 0.7, step);
    scene.physics.integration = Integration::kSecondOrder;
    World world(scene);
    grasp(world, 1.0);
    world.move_carrier(above(world, kGraspHeight + 0.1), 0.1);
    run(world, 2);
    EXPECT_NEAR(height_of(world), 0.1, 1e-3) << step;
    const double before = height_of(world);
    run(world, 3);
    EXPECT_NEAR(height_of(world), before, 3e-6) << step;
    EXPECT_NEAR(world.wrist_wrench().force.z(), 0.35 * 9.81, 1e-5) << step;
  }
}

}  // namespace
}  // namespace prehend::simulation
