// What no step may create or lose, and what must not matter.

#include <cmath>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "prehend/contact/parallel_grasp.h"
#include "prehend/contact/rotation.h"
#include "slabs.h"

namespace prehend::contact {
namespace {

using namespace testing;

TEST(Conservation, EnergyNeverGrowsInABounce) {
  for (const double h : {1e-5, 1e-4, 1e-3, 1e-2}) {
    for (const double damping : {0.0, 0.02, 10.0}) {
      SlabOptions options;
      options.height = 0.004;
      options.law.damping = damping;
      GraspStepper stepper(slab(options), steps_of(h));
      double energy = stepper.system().energy(stepper.state());
      const double zero = -0.3 * kGravity * 0.01, start = energy + std::abs(zero);
      for (int i = 0; i < 3000 && stepper.state().time < 2; ++i) {
        stepper.step(1e9);
        const double now = stepper.system().energy(stepper.state());
        ASSERT_LE(now, energy + 1e-9 * start) << h << " s, " << damping << " N s/m, step " << i;
        energy = now;
      }
    }
  }
}

// A body and a free jaw that collide: m v + M V.
TEST(Conservation, MomentumOfAFreePair) {
  GraspModel model = slab({.mass = 0.3, .height = 1e-4, .gravity = 0});
  model.pads[0].slide = 0;
  model.pads[0].direction_G = Eigen::Vector3d::UnitZ();
  model.slides.push_back({.mass = 0.05});
  for (const Integration integration :
       {Integration::kFirstOrder, Integration::kSecondOrder, Integration::kAdaptive}) {
    GraspStepper stepper(model, steps_of(1e-4, integration));
    GraspState state = stepper.state();
    state.velocity.z() = -0.1;
    stepper.set_state(state);
    stepper.advance(0.05);
    const double momentum =
        0.3 * stepper.state().velocity.z() + 0.05 * stepper.state().slide_velocity[0];
    EXPECT_NEAR(momentum, -0.03, 1e-12 * 0.03);
    EXPECT_LT(stepper.state().slide_velocity[0], -0.05) << "they did collide";
  }
}

TEST(Conservation, AngularMomentumOfATumblingBody) {
  GraspModel model = slab({.mass = 1, .size = {0.1, 0.06, 0.03}, .height = 0.5, .gravity = 0});
  for (const Integration integration : {Integration::kFirstOrder, Integration::kSecondOrder}) {
    GraspStepper stepper(model, steps_of(1e-3, integration));
    GraspState state = stepper.state();
    state.angular_velocity = {3, 5, -2};
    stepper.set_state(state);
    const auto momentum = [&] {
      const GraspState& s = stepper.state();
      return Eigen::Vector3d(s.q_WB * (model.inertia * (s.q_WB.conjugate() * s.angular_velocity)));
    };
    const Eigen::Vector3d before = momentum();
    stepper.advance(1);
    EXPECT_LT((momentum() - before).norm(), 1e-8 * before.norm());
  }
}

// The same grasp seen from another frame, in other units of length, on other threads.
GraspModel lifted_box(double scale = 1) {
  ParallelGraspOptions options;
  options.box_size = scale * Eigen::Vector3d(0.05, 0.05, 0.06);
  options.opening = 0.0505 * scale;
  options.law = elastic_law();
  options.pad.width *= scale;
  options.pad.length *= scale;
  options.pad.thickness *= scale;
  // A texel's area scales with scale^2: the same constants for each texel.
  for (double* constant : {&options.law.stiffness, &options.law.damping,
                           &options.law.bristle_stiffness, &options.law.bristle_damping}) {
    *constant /= scale * scale;
  }
  options.law.stribeck_velocity *= scale;
  GraspModel model = parallel_grasp(options);
  model.gravity *= scale;
  return model;
}

GraspState held(const GraspModel& model, double force, const geometry::RigidTransform& X_WG,
                double tolerance = 1e-9) {
  SolveOptions solve;
  solve.velocity_tolerance = tolerance;
  GraspStepper stepper(model, steps_of(1e-3), solve);
  GripperMotion motion;
  motion.X_WG = X_WG;
  stepper.system().set_gripper_motion(motion);
  for (int slide : {0, 1}) stepper.system().set_command(slide, {.force = force}, 0);
  stepper.advance(0.3);
  return stepper.state();
}

TEST(Invariance, Frame) {
  const GraspModel model = lifted_box();
  const GraspState here = held(model, 10, geometry::RigidTransform::Identity());
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.linear() = rotation_by({0.4, -1.1, 0.7}).toRotationMatrix();
  X.translation() = Eigen::Vector3d(0.3, -0.2, 0.5);
  GraspModel turned = model;
  turned.gravity = X.linear() * model.gravity;
  turned.X_WB = X * model.X_WB;
  const GraspState there = held(turned, 10, X);
  EXPECT_GT(here.p_WB.norm(), 1e-5) << "it sags";
  EXPECT_LT((X.inverse() * there.p_WB - here.p_WB).norm(), 1e-9 * 0.05);
  EXPECT_LT((X.linear().transpose() * there.velocity - here.velocity).norm(), 1e-9);
}

TEST(Invariance, Scale) {
  const GraspState small = held(lifted_box(), 10, geometry::RigidTransform::Identity(), 1e-12);
  const GraspState large = held(lifted_box(4), 40, geometry::RigidTransform::Identity(), 4e-12);
  EXPECT_LT((large.p_WB / 4 - small.p_WB).norm(), 1e-9 * 0.05);
  EXPECT_NEAR(large.slide_position[0] / 4, small.slide_position[0], 1e-9 * 0.05);
}

TEST(Invariance, TexelOrder) {
  const GraspModel model = lifted_box();
  GraspModel other = model;
  std::vector<std::size_t> order(84);
  for (std::size_t i = 0; i < 84; ++i) order[i] = (i * 37 + 11) % 84;
  for (PadMount& pad : other.pads) pad.layout = pad.layout.reordered(order);
  const GraspState a = held(model, 10, geometry::RigidTransform::Identity());
  const GraspState b = held(other, 10, geometry::RigidTransform::Identity());
  EXPECT_LT((a.p_WB - b.p_WB).norm(), 1e-9 * 0.05);
}

TEST(Invariance, ThreadsAndRepetitionAreBitwise) {
  const GraspModel model = lifted_box();
  GraspState results[4] = {held(model, 10, geometry::RigidTransform::Identity()), {}, {}, {}};
  std::vector<std::thread> threads;
  for (int i = 1; i < 4; ++i) {
    threads.emplace_back(
        [&, i] { results[i] = held(model, 10, geometry::RigidTransform::Identity()); });
  }
  for (std::thread& thread : threads) thread.join();
  for (int i = 1; i < 4; ++i) {
    EXPECT_EQ(results[i].p_WB, results[0].p_WB);
    EXPECT_EQ(results[i].pads[0].bristle_v, results[0].pads[0].bristle_v);
  }
}

TEST(Invariance, RestoredStateContinuesBitwise) {
  GraspStepper stepper(lifted_box(), steps_of(1e-3, Integration::kSecondOrder));
  for (int slide : {0, 1}) stepper.system().set_command(slide, {.force = 10}, 0);
  stepper.advance(0.1);
  const GraspState saved = stepper.state();
  stepper.advance(0.2);
  const GraspState first = stepper.state();
  stepper.set_state(saved);
  stepper.advance(0.2);
  EXPECT_EQ(stepper.state().p_WB, first.p_WB);
  EXPECT_EQ(stepper.state().pads[1].bristle_u, first.pads[1].bristle_u);
}

}  // namespace
}  // namespace prehend::contact
