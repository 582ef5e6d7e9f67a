#include "prehend/launch/stop_schedule.h"

#include <gtest/gtest.h>
#include <signal.h>

namespace prehend::launch {
namespace {

using std::chrono::milliseconds;

constexpr StopTimes kTimes{milliseconds(3000), milliseconds(1000), milliseconds(2000)};
const StopSchedule::Time kBegun{std::chrono::hours(1)};

TEST(StopSchedule, TermAfterPatienceThenKill) {
  StopSchedule stop(kTimes, kBegun);
  EXPECT_EQ(stop.take_due(kBegun + milliseconds(2999)), std::nullopt);
  EXPECT_EQ(stop.take_due(kBegun + milliseconds(3100)), SIGTERM);
  EXPECT_EQ(stop.take_due(kBegun + milliseconds(4099)), std::nullopt)
      << "1 s from when it was sent";
  EXPECT_EQ(stop.take_due(kBegun + milliseconds(4100)), SIGKILL);
  EXPECT_FALSE(stop.next());
  EXPECT_FALSE(stop.is_hopeless(kBegun + milliseconds(5000)));
  EXPECT_TRUE(stop.is_hopeless(kBegun + milliseconds(5100)));
}

TEST(StopSchedule, AHurryLeavesItsTimeFromTheFirstSignalOn) {
  StopSchedule stop(kTimes, kBegun);
  stop.hurry();
  EXPECT_EQ(stop.take_due(kBegun + milliseconds(1999)), std::nullopt);
  EXPECT_EQ(stop.take_due(kBegun + milliseconds(2000)), SIGKILL);
  EXPECT_EQ(stop.take_due(kBegun + milliseconds(9000)), std::nullopt) << "once";
}

TEST(StopSchedule, AHurryAfterSigtermKillsAtOnce) {
  StopSchedule stop(kTimes, kBegun);
  EXPECT_EQ(stop.take_due(kBegun + milliseconds(3000)), SIGTERM);
  stop.hurry();
  EXPECT_EQ(stop.take_due(kBegun + milliseconds(3001)), SIGKILL);
}

TEST(StopSchedule, AWriterIsNotHurried) {
  StopSchedule stop({milliseconds(30000), milliseconds(1000), milliseconds(30000)}, kBegun);
  stop.hurry();
  EXPECT_EQ(stop.take_due(kBegun + milliseconds(29999)), std::nullopt);
  EXPECT_EQ(stop.take_due(kBegun + milliseconds(30000)), SIGKILL);
}

}  // namespace
}  // namespace prehend::launch
