// A cube held between two jaws, and the adaptive step.

#include <cmath>
#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

#include "prehend/contact/parallel_grasp.h"
#include "slabs.h"

namespace {
// Counts what this program allocates, for the test that steps do not.
thread_local long allocations = 0;
}  // namespace
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size ? size : 1)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace prehend::contact {
namespace {

using namespace testing;

GraspModel held_cube(double mass, const TexelLaw& law = elastic_law()) {
  ParallelGraspOptions options;
  options.mass = mass;
  options.opening = 0.0504;
  options.law = law;
  return parallel_grasp(options);
}

// Jaws close on the weightless cube, then its weight comes on smoothly until 1 s.
void grip(GraspStepper& stepper, double mass) {
  const double weight = mass * kGravity, force = 1.2 * weight / (2 * 0.8);
  for (int slide : {0, 1}) stepper.system().set_command(slide, {.force = force}, 0);
  for (int i = 0; i <= 100; ++i) {
    const double t = std::max(0.0, (i - 50) / 50.0), share = t * t * (3 - 2 * t);
    stepper.system().set_body_wrench((Vector6() << 0, 0, weight * (1 - share), 0, 0, 0).finished());
    stepper.advance(0.01 * (i + 1));
  }
}

class HoldCreep : public ::testing::TestWithParam<std::tuple<double, double>> {};
TEST_P(HoldCreep, StaysBelowATenthOfAMicrometreASecond) {
  const auto [mass, h] = GetParam();
  GraspStepper stepper(held_cube(mass), steps_of(h));
  grip(stepper, mass);
  stepper.advance(5);
  const double settled = stepper.state().p_WB.z();
  stepper.advance(15);
  EXPECT_LT(std::abs(stepper.state().p_WB.z() - settled) / 10, 1e-7);
  EXPECT_LT(std::abs(settled), 0.01) << "held at all";
  EXPECT_LT(stepper.state().velocity.norm(), 1e-7);
}
// Fine steps cost time here; eval_hold runs the whole table.
INSTANTIATE_TEST_SUITE_P(TenGramsToTenKilograms, HoldCreep,
                         ::testing::Combine(::testing::Values(0.01, 0.1, 1.0, 10.0),
                                            ::testing::Values(1e-2, 1e-3)));
INSTANTIATE_TEST_SUITE_P(TenthOfAMillisecond, HoldCreep,
                         ::testing::Combine(::testing::Values(0.01, 10.0),
                                            ::testing::Values(1e-4)));

// The paper's bristle creeps when the load ripples; the elasto-plastic one does not.
TEST(Hold, ElastoPlasticBristlesDoNotCreepUnderRipple) {
  const auto creep = [](BristleLaw bristle) {
    TexelLaw law = elastic_law();
    law.bristle_law = bristle;
    GraspStepper stepper(held_cube(0.3, law), steps_of(1e-3));
    for (int slide : {0, 1}) stepper.system().set_command(slide, {.force = 6}, 0);
    stepper.advance(1);
    const auto ripple = [&](double until) {
      while (stepper.state().time < until) {
        const double push = 1.0 * std::sin(2 * M_PI * 20 * stepper.state().time);
        stepper.system().set_body_wrench((Vector6() << 0, 0, push, 0, 0, 0).finished());
        stepper.step(1e9);
      }
    };
    ripple(2);
    const double before = stepper.state().p_WB.z();
    ripple(4);
    return std::abs(stepper.state().p_WB.z() - before);
  };
  EXPECT_GT(creep(BristleLaw::kLuGre), 1e-5);
  EXPECT_LT(creep(BristleLaw::kElastoPlastic), 1e-9);
}

TEST(Hold, TooWeakDrops) {
  GraspStepper stepper(held_cube(1), steps_of(1e-3));
  for (int slide : {0, 1}) {
    stepper.system().set_command(slide, {.force = 0.9 * kGravity / (2 * 0.8)}, 0);
  }
  stepper.advance(1);
  EXPECT_LT(stepper.state().p_WB.z(), -0.1);
}

TEST(Steps, DoNotAllocate) {
  for (const Integration integration : {Integration::kExplicit, Integration::kFirstOrder,
                                        Integration::kSecondOrder, Integration::kAdaptive}) {
    const double h = integration == Integration::kExplicit ? 1e-5 : 1e-3;
    GraspStepper stepper(held_cube(0.3), steps_of(h, integration));
    for (int slide : {0, 1}) stepper.system().set_command(slide, {.force = 6}, 0);
    stepper.advance(0.02);
    const long before = allocations;
    stepper.advance(0.04);
    EXPECT_EQ(allocations - before, 0);
  }
}

// Jaws close on a falling cube and catch it: impacts, slip and stick in a few milliseconds.
TEST(Adaptive, StaysNearAFineReferenceWithFewSteps) {
  for (const double mass : {0.1, 1.0}) {
    const auto caught = [&](const StepOptions& options) {
      auto stepper = std::make_unique<GraspStepper>(held_cube(mass), options);
      const double force = 1.2 * mass * kGravity / (2 * 0.8);
      for (int slide : {0, 1}) stepper->system().set_command(slide, {.force = force}, 0);
      stepper->advance(0.5);
      return stepper;
    };
    const auto reference = caught(steps_of(2e-5, Integration::kSecondOrder));
    StepOptions options = steps_of(1e-4, Integration::kAdaptive);
    options.tolerance = 1e-8;
    const auto adaptive = caught(options);
    const double error = (adaptive->state().p_WB - reference->state().p_WB).norm();
    EXPECT_LT(error, 1e-5) << mass;
    EXPECT_LT(adaptive->steps() + adaptive->rejected(), 600) << "the reference takes 25000";
    RecordProperty("error_um_" + std::to_string(mass), std::to_string(1e6 * error));
  }
}

TEST(Adaptive, FindsTheMomentOfAnEvent) {
  GraspModel model = slab({.mass = 0.3, .height = 0.05});
  GraspStepper stepper(model, steps_of(1e-3, Integration::kAdaptive));
  const bool happened = stepper.advance_until(
      1, [&](const GraspState& state) { return stepper.system().pad_force(state, 0) > 0; }, 1e-5);
  EXPECT_TRUE(happened);
  EXPECT_NEAR(stepper.state().time, std::sqrt(2 * 0.05 / kGravity), 2e-5);
}

TEST(Explicit, AgreesWithTheImplicitStepWhereItIsStable) {
  const auto run = [](Integration integration) {
    GraspStepper stepper(held_cube(0.3), steps_of(5e-6, integration));
    for (int slide : {0, 1}) stepper.system().set_command(slide, {.force = 6}, 0);
    stepper.advance(0.05);
    return stepper.state();
  };
  const GraspState a = run(Integration::kExplicit), b = run(Integration::kSecondOrder);
  EXPECT_LT((a.p_WB - b.p_WB).norm(), 2e-7);
  EXPECT_NEAR(a.slide_position[0], b.slide_position[0], 1e-7);
}

}  // namespace
}  // namespace prehend::contact
