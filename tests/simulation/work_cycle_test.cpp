#include "prehend/simulation/work_cycle.h"

#include <cmath>

#include <gtest/gtest.h>

namespace prehend::simulation {
namespace {

using contact::Integration;

WorkCycleOptions cycle(Integration integration = Integration::kFirstOrder, double step = 2e-3) {
  WorkCycleOptions options;
  options.grasp.law.viscous_friction = 0.1;
  options.grasp.law.bristle_law = contact::BristleLaw::kElastoPlastic;
  options.grasp.law.return_map = true;
  options.grip_force = 10;
  options.step.integration = integration;
  options.step.step = step;
  return options;
}

const PhaseEnd& end_of(const WorkCycleResult& result, CyclePhase phase) {
  return result.ends[static_cast<int>(phase)];
}

TEST(WorkCycle, LiftsHoldsAndPutsDownAtEachCoverage) {
  for (const double coverage : {0.15, 0.3, 0.6, 1.0}) {
    WorkCycleOptions options = cycle();
    options.coverage = coverage;
    const WorkCycleResult result = run_work_cycle(options);
    const CycleSample& hold = end_of(result, CyclePhase::kHold).sample;
    const CycleSample& rest = end_of(result, CyclePhase::kRetreat).sample;
    EXPECT_NEAR(hold.left, 10, 1e-6);
    EXPECT_NEAR(hold.right, hold.left, 1e-9);
    EXPECT_NEAR(hold.box.z() - rest.box.z(), 0.1, 0.001) << coverage;
    EXPECT_NEAR(rest.box.z(), 0.025, 1e-4) << "stands on the table again";
    EXPECT_EQ(rest.left, 0);
    // A force of 10 N on the texels that touch.
    int touched = 0;
    for (const double force : end_of(result, CyclePhase::kHold).left_image) touched += force > 0;
    EXPECT_EQ(touched, 6 * std::lround(coverage * 14)) << coverage;
    EXPECT_NEAR(result.touch_time, 6, 0.01) << "10 mm at 10 mm/s";
  }
}

// Opening once drove the jaws through the box: the servo's force flipped between its limits.
TEST(WorkCycle, NeverPressesHarderThanAskedAndOpensOutward) {
  for (const Integration integration :
       {Integration::kFirstOrder, Integration::kSecondOrder, Integration::kAdaptive}) {
    for (const double coverage : {0.15, 1.0}) {
      WorkCycleOptions options = cycle(integration);
      options.coverage = coverage;
      options.sample_period = 0.01;
      const WorkCycleResult result = run_work_cycle(options);
      double opening = 0;
      for (const CycleSample& sample : result.samples) {
        ASSERT_LT(sample.left, 10.01) << sample.time;
        ASSERT_GT(sample.opening, 0.04) << sample.time;
        if (sample.phase != CyclePhase::kRelease) continue;
        ASSERT_GE(sample.opening, opening - 1e-9);
        opening = sample.opening;
      }
      EXPECT_NEAR(opening, 0.058, 0.002);
    }
  }
}

TEST(WorkCycle, StictionKeepsForceFromThePads) {
  WorkCycleOptions options = cycle();
  options.stiction = 3;
  const WorkCycleResult result = run_work_cycle(options);
  EXPECT_NEAR(end_of(result, CyclePhase::kHold).sample.left, 7, 0.3);
}

TEST(WorkCycle, AdaptiveStepsStayWithinTenMicrometresOfAReference) {
  WorkCycleOptions options = cycle(Integration::kSecondOrder, 2e-4);
  options.sample_period = 0.1;
  const WorkCycleResult reference = run_work_cycle(options);
  WorkCycleOptions adaptive = cycle(Integration::kAdaptive, 1e-4);
  adaptive.sample_period = 0.1;
  adaptive.step.tolerance = 1e-6;
  adaptive.step.most_step = 0.5;
  const WorkCycleResult result = run_work_cycle(adaptive);
  EXPECT_LT(largest_difference(result, reference), 1e-5);
  EXPECT_LT(result.steps, 2000) << "the reference takes 225000";
}

TEST(WorkCycle, RefusesBadOptionsByName) {
  const auto refused = [](auto change, const std::string& name) {
    WorkCycleOptions options;
    change(options);
    try {
      run_work_cycle(options);
      FAIL() << name << " was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  };
  refused([](WorkCycleOptions& o) { o.coverage = 0; }, "coverage");
  refused([](WorkCycleOptions& o) { o.coverage = 1.1; }, "coverage");
  refused([](WorkCycleOptions& o) { o.close_speed = -1; }, "close_speed");
  refused([](WorkCycleOptions& o) { o.stiction = std::nan(""); }, "stiction");
  refused([](WorkCycleOptions& o) { o.grasp.mass = 0; }, "mass");
}

}  // namespace
}  // namespace prehend::simulation
