// Chains of joints of prehend's own engine: closed forms and written-out equations of motion.

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/simulation/engine_scenes.h"

namespace prehend::simulation::engines {
namespace {

EngineScene pendulum(double angle, double step, const char* solver) {
  EngineScene scene;
  scene.step = step;
  scene.solver = solver;
  scene.bodies = {box(0.2, {0.02, 0.02, 0.02}, {0.5 * std::sin(angle), 0, -0.5 * std::cos(angle)})};
  scene.bodies[0].collides = false;
  scene.joints = {hinge(-1, 0, Eigen::Vector3d::Zero())};
  return scene;
}

// Period to the fourth power of the angle: 2 pi sqrt(I / m g l) (1 + a^2/16 + 11 a^4/3072).
TEST(Multibody, PendulumHasItsPeriod) {
  const double angle = 0.4;
  const EngineScene scene = pendulum(angle, 2e-3, "second_order");
  const auto engine = loaded(scene);
  const double inertia = 0.2 * 0.25 + 0.2 / 6 * 4e-4;
  const double period = 2 * M_PI * std::sqrt(inertia / (0.2 * 9.81 * 0.5)) *
                        (1 + angle * angle / 16 + 11 * std::pow(angle, 4) / 3072);
  // Times at which it hangs straight: every half period, from a quarter on.
  std::vector<double> crossings;
  double before = angle;
  for (int i = 0; i < 5000; ++i) {
    engine->step();
    const Eigen::Vector3d p = engine->body(0).X_WB.translation();
    const double now = std::atan2(p.x(), -p.z());
    if (before * now < 0) crossings.push_back((i + before / (before - now)) * scene.step);
    before = now;
    EXPECT_NEAR(p.norm(), 0.5, 1e-12) << "joints do not drift";
  }
  ASSERT_GT(crossings.size(), 10u);
  const double measured =
      2 * (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  EXPECT_NEAR(measured, period, 5e-4 * period);
}

TEST(Multibody, SecondOrderStepsAreOfSecondOrder) {
  const auto angle_after = [](double step, const char* solver) {
    const EngineScene scene = pendulum(1.2, step, solver);
    const auto engine = loaded(scene);
    run(*engine, scene, 0.64);
    return engine->joint_position(0);
  };
  const double truth = angle_after(1e-4, "second_order");
  for (const char* solver : {"first_order", "second_order"}) {
    const double coarse = std::abs(angle_after(8e-3, solver) - truth);
    const double fine = std::abs(angle_after(4e-3, solver) - truth);
    const double order = std::log2(coarse / fine);
    EXPECT_GT(order, solver == std::string("second_order") ? 1.8 : 0.85) << coarse << ' ' << fine;
  }
}

TEST(Multibody, DoublePendulumFollowsItsEquations) {
  const Eigen::Vector2d truth = double_pendulum_reference(0.5);
  EngineScene scene = double_pendulum(5e-4);
  scene.solver = "second_order";
  const auto engine = loaded(scene);
  const double energy = engine->energy();
  double least = energy, most = energy;
  for (int i = 0; i < 1000; ++i) {
    engine->step();
    least = std::min(least, engine->energy());
    most = std::max(most, engine->energy());
  }
  EXPECT_NEAR(engine->joint_position(0), truth[0], 2e-4);
  EXPECT_NEAR(engine->joint_position(1), truth[1], 2e-4);
  // Of the 1.4 J that move to and fro.
  EXPECT_LT(most - least, 1e-3);
  EXPECT_LT(most - energy, 1e-4) << "energy does not grow";
}

TEST(Multibody, JointsOfAChainTurnWithTheirParents) {
  EngineScene scene;
  scene.gravity.setZero();
  // A turntable, and on it a slide that leads outwards, held by nothing: centrifugal force.
  scene.solver = "second_order";
  scene.bodies = {box(5, {0.4, 0.4, 0.02}, {0, 0, 0}),
                  box(0.1, {0.02, 0.02, 0.02}, {0.1, 0, 0.05})};
  for (EngineBody& body : scene.bodies) body.collides = false;
  scene.bodies[0].moments = {1e3, 1e3, 1e6};  // heavy: it keeps its speed
  scene.bodies[0].angular_velocity.z() = 2;
  EngineJoint slide;
  slide.parent = 0;
  slide.body = 1;
  scene.joints = {hinge(-1, 0, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()), slide};
  const auto engine = loaded(scene);
  run(*engine, scene, 0.5);
  // r = r0 cosh(w t)
  EXPECT_NEAR(engine->joint_position(1), 0.1 * (std::cosh(1.0) - 1), 2e-6);
  const Eigen::Vector3d p = engine->body(1).X_WB.translation();
  EXPECT_NEAR(std::atan2(p.y(), p.x()), 1, 1e-6);
}

TEST(Multibody, CoupledJawsMoveTogether) {
  EngineScene scene;
  scene.gravity.setZero();
  scene.bodies = {box(0.05, {0.02, 0.01, 0.02}, {0, 0.05, 0}),
                  box(0.15, {0.02, 0.01, 0.02}, {0, -0.05, 0})};
  for (const int body : {0, 1}) {
    EngineJoint slide;
    slide.body = body;
    slide.axis_W = Eigen::Vector3d(0, -1, 0);
    scene.joints.push_back(slide);
  }
  scene.joints[1].follows = 0;
  scene.joints[1].ratio = -1;
  const auto engine = loaded(scene);
  engine->set_joint_force(0, 0.3);
  engine->set_joint_force(1, -0.1);  // 0.4 N on the coordinate
  run(*engine, scene, 0.1);
  EXPECT_NEAR(engine->joint_position(0), 0.5 * 0.4 / 0.2 * 0.01, 0.5e-3 * 0.2 + 1e-9);
  EXPECT_DOUBLE_EQ(engine->joint_position(1), -engine->joint_position(0));
  EXPECT_NEAR(engine->body(1).X_WB.translation().y(), -0.05 + engine->joint_position(0), 1e-12);
}

}  // namespace
}  // namespace prehend::simulation::engines
