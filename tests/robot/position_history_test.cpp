#include "prehend/robot/position_history.h"

#include <cmath>

#include <gtest/gtest.h>

namespace prehend::robot {
namespace {

constexpr std::int64_t kMs = 1'000'000;

Positions both(double q) { return Positions::Constant(2, q); }

// Against the closed form: of a motion at constant speed nothing is lost.
TEST(PositionHistory, IsLinearBetweenItsEntries) {
  PositionHistory history;
  for (int i = 0; i <= 100; ++i) history.add(i * 10 * kMs, both(0.01 * i));
  for (const std::int64_t ms : {0, 5, 10, 123, 999, 1000}) {
    ASSERT_TRUE(history.at(ms * kMs)) << ms;
    EXPECT_NEAR((*history.at(ms * kMs))[1], 1e-3 * static_cast<double>(ms), 1e-12);
  }
}

TEST(PositionHistory, SaysNothingOfWhatItDoesNotKnow) {
  PositionHistory history(1000 * kMs, 50 * kMs);
  EXPECT_FALSE(history.at(0));
  history.add(100 * kMs, both(1));
  EXPECT_FALSE(history.at(99 * kMs)) << "before the first";
  EXPECT_EQ((*history.at(150 * kMs))[0], 1) << "it has not moved far since";
  EXPECT_FALSE(history.at(151 * kMs)) << "too old";
  history.add(200 * kMs, both(2));
  EXPECT_FALSE(history.at(150 * kMs)) << "a hole";
  history.add(1300 * kMs, both(3));
  EXPECT_FALSE(history.at(200 * kMs)) << "forgotten";
  history.add(500 * kMs, both(4));
  EXPECT_FALSE(history.at(1300 * kMs)) << "the clock was set back";
  EXPECT_EQ((*history.at(500 * kMs))[0], 4);
}

}  // namespace
}  // namespace prehend::robot
