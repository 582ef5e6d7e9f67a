#include "prehend/control/input_watch.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prehend::control {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kTick = 0.01;  // s

std::vector<InputAge> of_age(double age) {
  return {{"the scale", 0.0, 0.25}, {"the wrist's force", age, 0.25}};
}

TEST(InputWatch, WhatIsOlderThanItsLimitIsLost) {
  InputWatch watch;
  watch.begin(10);
  double now = 10;
  for (; now < 11; now += kTick) EXPECT_THAT(watch.lost(now, of_age(0.24)), IsEmpty()) << now;
  const auto lost = watch.lost(now, of_age(0.26));
  ASSERT_THAT(lost, SizeIs(1));
  EXPECT_EQ(lost[0].name, "the wrist's force");
  EXPECT_EQ(describe(lost), "the wrist's force (0.26 s old, at most 0.25 s)");
}

TEST(InputWatch, GivesEveryInputItsLimitFromTheBeginning) {
  InputWatch watch;
  watch.begin(10);
  double now = 10;
  while (now < 12 && watch.lost(now, of_age(5 + now)).empty()) now += kTick;
  EXPECT_NEAR(now - 10, 0.25, 1.5 * kTick);
}

// After a stall the clock may be heard before the messages that waited with it: judged at once, a
// cycle on a busy machine was ended by inputs that were not lost.
TEST(InputWatch, AfterAStallInputsMayBeOlderByItUntilTheyHaveHadTimeToCome) {
  InputWatch watch;
  watch.begin(10);
  for (double now = 10; now < 11; now += kTick) ASSERT_THAT(watch.lost(now, of_age(0)), IsEmpty());
  double now = 12;
  while (now < 13 && watch.lost(now, of_age(now - 10.99)).empty()) now += kTick;
  EXPECT_NEAR(now - 12, 0.25, 1.5 * kTick);
  InputWatch other;  // as old, though nothing stalled
  other.begin(10);
  for (now = 10; now < 11; now += kTick) ASSERT_THAT(other.lost(now, of_age(0)), IsEmpty());
  EXPECT_THAT(other.lost(now, of_age(1)), SizeIs(1));
}

// Regression: three large messages in a row held a cycle up three times, each time for less than
// half of a limit, and what waited behind them was taken for lost.
TEST(InputWatch, SeveralStallsAddUp) {
  InputWatch watch;
  watch.begin(10);
  for (double now = 10; now < 11; now += kTick) ASSERT_THAT(watch.lost(now, of_age(0)), IsEmpty());
  for (const double stalled : {0.12, 0.24, 0.36}) {
    EXPECT_THAT(watch.lost(11 + stalled, of_age(stalled)), IsEmpty());
  }
  EXPECT_THAT(watch.lost(11.37, of_age(0)), IsEmpty());
  EXPECT_THAT(watch.lost(11.38, of_age(0.7)), SizeIs(1)) << "older than all stalls";
}

TEST(InputWatch, InALoopThatIsSlowThroughoutWhatIsSilentIsLostAfterFourLimits) {
  InputWatch watch;
  watch.begin(10);
  double now = 10;
  while (now < 20 && watch.lost(now, of_age(now - 10)).empty()) now += 0.1;
  EXPECT_NEAR(now - 10, 5 * 0.25, 0.11);
}

TEST(InputWatch, WhatNeverCameOrHasEndedIsLostAtOnce) {
  InputWatch watch;
  watch.begin(10);
  const std::vector<InputAge> inputs{{"the scale", std::nullopt, 0.25},
                                     {"the server", std::numeric_limits<double>::infinity(), 2}};
  const auto lost = watch.lost(10, inputs);
  EXPECT_EQ(describe(lost), "the scale (nothing has come), the server (ended)");
  EXPECT_EQ(names_of(lost), "the scale, the server");
}

// A stamp of another host's clock, an hour ahead, would count as fresh for an hour.
TEST(InputWatch, StampsInTheFutureAreNotFresh) {
  EXPECT_THAT(stale_inputs(of_age(-0.2)), IsEmpty());
  EXPECT_THAT(describe(stale_inputs(of_age(-3600))), HasSubstr("set the clocks"));
  EXPECT_THAT(stale_inputs(of_age(std::nan(""))), SizeIs(1));
}

}  // namespace
}  // namespace prehend::control
