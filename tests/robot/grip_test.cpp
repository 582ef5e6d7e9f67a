#include "prehend/robot/grip.h"

#include <cstdint>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::robot {
namespace {

TEST(Grip, TouchedIsWhatShowsMoreThanTheThreshold) {
  const std::vector<std::uint16_t> counts{0, 10, 11, 4095};
  EXPECT_DOUBLE_EQ(touched_area(counts, kTouchCounts, 2e-6), 4e-6);
  EXPECT_DOUBLE_EQ(touched_area(counts, 0, 2e-6), 6e-6);
  EXPECT_EQ(touched_area(std::vector<std::uint32_t>{}, 0, 2e-6), 0);
}

TEST(Grip, MeanOfThePadsThatTouchAndAreFresh) {
  const MeanTouch mean =
      mean_touch({{4, 1e-4, 0}, {8, 3e-4, 0.1}, {0.3, 1, 0}, {100, 1, 0.3}}, 0.3, 0.25);
  EXPECT_EQ(mean.pads, 2);
  EXPECT_DOUBLE_EQ(mean.sum, 6);
  EXPECT_DOUBLE_EQ(mean.area, 2e-4);
  EXPECT_EQ(mean_touch({}, 0.3, 0.25).sum, 0);
}

// Pads that feel 50 N at the greatest effort: 12 N are reached from below, by no more than the
// rule's tolerance.
TEST(Grip, EffortRisesUntilThePadsFeelTheForce) {
  double share = first_effort_share(0.25);
  EXPECT_LT(50 * share, 12);
  for (int i = 0; i < 100; ++i) {
    const auto next = next_effort_share(share, {2, 50 * share, 1e-4}, 12);
    if (!next) break;
    EXPECT_GT(*next, share);
    share = *next;
  }
  EXPECT_NEAR(50 * share, 12, 1.2);
  EXPECT_EQ(next_effort_share(1, {2, 1, 1e-4}, 12), std::nullopt) << "there is no more";
  EXPECT_EQ(next_effort_share(0.9, {0, 0, 0}, 12), 1.0) << "nothing is felt yet";
}

TEST(Grip, RefusesOptionsOutOfRange) {
  GripOptions options;
  EXPECT_NO_THROW(options.validate());
  options.touch_force = 0;
  EXPECT_THROW(options.validate(), std::invalid_argument);
  options = {};
  options.overrun = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(options.validate(), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::robot
