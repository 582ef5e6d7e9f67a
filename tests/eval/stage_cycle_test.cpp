// What the soft-contact paper says of its work cycle (figures 4 to 7), of ours.

#include "eval/touch/stage_cycle.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace prehend::eval::touch {
namespace {

StageCycle covered(double coverage) {
  StageCycleOptions options;
  options.coverage = coverage;
  return run_stage_cycle(options);
}

double differ(const StageCycle& cycle) {
  return std::abs(cycle.held_left - cycle.held_right) / ((cycle.held_left + cycle.held_right) / 2);
}

// Figures 5b, 6 and 7.
TEST(StageCycle, IdealPadsAgreeAndReachTheSumSwiftly) {
  double rise = 0, jump = 0, first_rise = 0;
  for (const double coverage : {0.15, 0.3, 0.6, 1.0}) {
    SCOPED_TRACE(coverage);
    const StageCycle cycle = covered(coverage);
    EXPECT_TRUE(cycle.result.success()) << cycle.result.reason;
    EXPECT_GT(cycle.raised, 0.095);
    EXPECT_LT(differ(cycle), 0.005);
    EXPECT_LT(cycle.settled_after, 1) << "s until it is, and stays, within 2 %";
    EXPECT_NEAR((cycle.held_left + cycle.held_right) / 2, 12, 0.24);
    EXPECT_GT(cycle.rise, rise) << "the more surface, the steeper";
    EXPECT_GT(cycle.jump, jump);
    rise = cycle.rise;
    jump = cycle.jump;
    if (first_rise == 0) first_rise = rise;
  }
  EXPECT_GT(rise, 1.5 * first_rise);
}

TEST(StageCycle, TheStifferTheContactTheGreaterTheJump) {
  double jump = 0;
  for (const double stiffness : {500.0, 1000.0, 2000.0}) {
    StageCycleOptions options;
    options.coverage = 0.15;
    options.stiffness = stiffness;
    const StageCycle cycle = run_stage_cycle(options);
    EXPECT_GT(cycle.jump, jump) << stiffness;
    jump = cycle.jump;
  }
}

// Figures 4 and 5a.
TEST(StageCycle, RealisticPadsDifferAndAStuckDriveMissesTheSum) {
  StageCycleOptions options;
  options.coverage = 0.3;
  options.realistic_pads = true;
  const StageCycle free = run_stage_cycle(options);
  options.stuck_drive = true;
  const StageCycle stuck = run_stage_cycle(options);
  for (const StageCycle* cycle : {&free, &stuck}) {
    EXPECT_TRUE(cycle->result.success()) << cycle->result.reason;
    EXPECT_GT(differ(*cycle), 0.1);
    EXPECT_LT(differ(*cycle), 0.5);
  }
  EXPECT_GT(stuck.settled_after, 1.1 * free.settled_after) << "reached with difficulty";
  const double missed = (stuck.held_left + stuck.held_right) / 2 / options.grip_force - 1;
  EXPECT_GT(std::abs(missed), 0.02);
  EXPECT_LT(std::abs(missed), 0.1);
}

TEST(StageCycle, IsTheSameRunAgain) {
  StageCycleOptions options;
  options.realistic_pads = options.stuck_drive = true;
  const StageCycle one = run_stage_cycle(options), other = run_stage_cycle(options);
  ASSERT_EQ(one.samples.size(), other.samples.size());
  for (std::size_t i = 0; i < one.samples.size(); ++i) {
    ASSERT_EQ(one.samples[i].left, other.samples[i].left) << i;
    ASSERT_EQ(one.samples[i].opening, other.samples[i].opening) << i;
  }
}

TEST(StageCycle, RefusesWhatIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {0.0, -1.0, 1.1, nan}) {
    EXPECT_THROW(covered(bad), std::invalid_argument) << bad;
  }
  for (const double bad : {0.0, -1.0, nan}) {
    StageCycleOptions options;
    options.grip_force = bad;
    EXPECT_THROW(run_stage_cycle(options), std::invalid_argument) << bad;
  }
  StageCycleOptions options;
  options.stiffness = -1;
  EXPECT_THROW(run_stage_cycle(options), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::eval::touch
