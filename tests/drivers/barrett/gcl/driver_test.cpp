// The BH8-262's driver on an emulated hand, both in simulated time.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/drivers/barrett/gcl/virtual_hand.h"

namespace prehend::drivers::barrett::gcl {
namespace {

using ::testing::HasSubstr;
using Kind = MotionReport::Kind;

void expect_at(const VirtualHand& g, const AxisValues& there) {
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_NEAR(g.hand.motion().position[i], there[i], 0.02) << axis_name(i);
    EXPECT_NEAR(g.driver.reading().position[i], there[i], 0.02) << axis_name(i);
  }
}

TEST(GclDriver, ConnectsByCtrlCAndMovesNothing) {
  VirtualHand g;
  ASSERT_TRUE(g.connect()) << ::testing::PrintToString(g.problems);
  EXPECT_EQ(g.driver.reading().state, DriverState::kUninitialised);
  EXPECT_EQ(g.sent.front(), std::string(1, kAbort));
  EXPECT_THAT(g.driver.reading().firmware, HasSubstr("4.3"));
  EXPECT_EQ(g.hand.moves(), 0u);
  EXPECT_EQ(g.driver.counters().strange, 0u);
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().temperature.has_value(); }));
  EXPECT_NEAR(*g.driver.reading().temperature, 25, 0.1);
}

TEST(GclDriver, NothingMovesBeforeHi) {
  VirtualHand g;
  ASSERT_TRUE(g.connect());
  EXPECT_THAT(g.send(g.goal(kThere)), HasSubstr("call /hand/initialise"));
  std::uint64_t ticket = 0;
  ASSERT_EQ(g.driver.initialise(g.now, ticket), "");
  EXPECT_EQ(g.driver.reading().state, DriverState::kInitialising);
  EXPECT_EQ(g.driver.initialise(g.now, ticket), "the hand is being initialised");
  ASSERT_TRUE(g.is_in(DriverState::kStanding, 25)) << ::testing::PrintToString(g.problems);
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kReached);
  EXPECT_EQ(g.lines("HI"), 1);
}

// Zero is where HI found the open stops, wherever it began.
TEST(GclDriver, HiFindsZero) {
  VirtualHand g;
  g.plant.place(0, 1.2);
  g.plant.place(kSpread, 0.7);
  ASSERT_TRUE(g.begin());
  EXPECT_NEAR(g.hand.motion().position[0], 0, 1e-3);
  EXPECT_NEAR(g.driver.reading().position[0], 0, 1e-2);
  EXPECT_NEAR(g.hand.motion().position[kSpread], 0, 1e-2);
}

TEST(GclDriver, HandThatWasInitialisedNeedsNoHi) {
  VirtualHand g({}, {.is_initialised = true});
  ASSERT_TRUE(g.connect());
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
  EXPECT_EQ(g.move(g.goal(kThere)).kind, Kind::kReached);
  EXPECT_EQ(g.lines("HI"), 0);
}

TEST(GclDriver, InitialisesByItselfOnceWhereItIsTold) {
  VirtualHand g({.initialisation = Initialisation::kAtStart});
  g.driver.connected(g.now);
  ASSERT_TRUE(g.is_in(DriverState::kStanding, 25));
  EXPECT_EQ(g.lines("HI"), 1);
  g.hand.reboot(g.now);
  ASSERT_TRUE(g.is_in(DriverState::kUninitialised, 25));
  g.run(3);
  EXPECT_EQ(g.lines("HI"), 1) << "a hand that was reset opens when it is asked to";
}

TEST(GclDriver, GoesThereByRealTimeBlocksAlone) {
  for (const Firmware firmware : {Firmware::k4_3, Firmware::k4_4}) {
    for (const unsigned fast : {0u, 38400u}) {
      VirtualHand g({.fast_baud = fast}, {.firmware = firmware});
      ASSERT_TRUE(g.begin()) << ::testing::PrintToString(g.problems);
      EXPECT_EQ(g.driver.baud(), fast == 0 ? kBaud : fast);
      EXPECT_EQ(g.hand.baud(), g.driver.baud());
      const MotionReport report = g.move(g.goal(kThere, 0.8));
      EXPECT_EQ(report.kind, Kind::kReached) << report.reason;
      expect_at(g, kThere);
      EXPECT_EQ(g.lines("M") + g.lines("C") + g.lines("1234M"), g.lines("C"));
      EXPECT_GT(g.hand.blocks(), 20u);
      EXPECT_FALSE(g.hand.is_looping()) << "the line is the supervisor's again";
      EXPECT_EQ(g.driver.counters().strange, 0u);
      EXPECT_NEAR(*g.driver.reading().temperature, 25, 0.6);
      EXPECT_EQ(g.move(g.goal({})).kind, Kind::kReached);
      expect_at(g, {});
    }
  }
}

TEST(GclDriver, KeepsTheSpeedThatItIsGiven) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  g.fastest.fill(0);
  ASSERT_EQ(g.move(g.goal({0.8, 0.8, 0.8, 0.8}, 0.4)).kind, Kind::kReached);
  for (std::size_t i = 0; i < kSpread; ++i) {
    EXPECT_LT(g.fastest[i], 0.42);
    EXPECT_GT(g.fastest[i], 0.36);
  }
  EXPECT_LT(g.fastest[kSpread], 0.55) << "steps of 0.1 rad/s";
}

// Either way LCV is counted, LCVC makes the same of it.
TEST(GclDriver, FactorOfVelocitiesIsAnOption) {
  VirtualHand g({.velocity_factor = 16}, {.velocity_factor = 16});
  ASSERT_TRUE(g.begin());
  g.fastest.fill(0);
  ASSERT_EQ(g.move(g.goal(kThere, 0.4)).kind, Kind::kReached);
  EXPECT_LT(g.fastest[0], 0.42);
  EXPECT_GT(g.fastest[0], 0.36);
}

TEST(GclDriver, WrongFactorIsNoticedAndStopped) {
  VirtualHand g({.velocity_factor = 16}, {.velocity_factor = 1});
  ASSERT_TRUE(g.begin());
  const MotionReport report = g.move(g.goal({2, 2, 2, 1}, 0.2));
  EXPECT_EQ(report.kind, Kind::kFailed);
  EXPECT_THAT(report.reason, HasSubstr("velocity_factor"));
  EXPECT_TRUE(g.run_until([&] { return !g.hand.is_moving(); }, 0.05));
}

TEST(GclDriver, GoalsBeyondLimitsAreRefused) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  EXPECT_THAT(g.send(g.goal({3, 0, 0, 0})), HasSubstr("F1 at 3 rad is outside 0 to 2.443"));
  EXPECT_THAT(g.send(g.goal({0, 0, 0, 4})), HasSubstr("spread at 4 rad"));
  EXPECT_THAT(g.send(g.goal({std::numeric_limits<double>::quiet_NaN(), 0, 0, 0})),
              HasSubstr("not finite"));
  EXPECT_THAT(g.send(g.goal(kThere, 0)), HasSubstr("speed"));
  g.run(1);
  EXPECT_FALSE(g.hand.is_looping());
}

TEST(GclDriver, PressesWhereSomethingIsInTheWayAndTheOthersGoOn) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  g.plant.put_object(0, 0.5);
  const MotionReport report = g.move(g.goal({1.2, 0.9, 0.9, 0.2}, 0.5, 60));
  EXPECT_EQ(report.kind, Kind::kBlocked) << report.reason;
  EXPECT_EQ(g.driver.reading().state, DriverState::kHolding);
  EXPECT_TRUE(g.driver.reading().blocked[0]);
  EXPECT_FALSE(g.driver.reading().blocked[1]);
  EXPECT_NEAR(g.hand.motion().position[0], 0.5, 0.01);
  EXPECT_NEAR(g.hand.motion().position[1], 0.9, 0.02);
  EXPECT_GT(g.driver.reading().effort[0], 0.1);
  g.run(1);
  EXPECT_GT(g.hand.motion().current[0], 10) << "its worm gear keeps what it presses with";
}

// What a stalled motor presses with is LCPG/4 times LCV.
TEST(GclDriver, EffortBoundsWhatMotorsPressWith) {
  for (const double command : {10.0, 40.0, 100.0}) {
    VirtualHand g;
    ASSERT_TRUE(g.begin());
    g.plant.put_object(0, 0.5);
    HandGoal goal = g.goal({1.2, 0, 0, 0}, 1, command);
    goal.moves = {true, false, false, false};
    EXPECT_EQ(g.move(goal).kind, Kind::kBlocked);
    EXPECT_LE(g.hand.motion().current[0], command + 1e-9);
    EXPECT_GT(g.hand.motion().current[0], 0.3 * command);
  }
}

// Strain ends a motion at the next block, not after the time of a stall.
TEST(GclDriver, StrainStopsAFingerWithinABlock) {
  VirtualHand g({.stall_time = 5, .strain_range = 20});
  ASSERT_TRUE(g.begin());
  g.plant.put_object(0, 0.5);
  ASSERT_EQ(g.send(g.goal({1.2, 0, 0, 0}, 0.5)), "");
  ASSERT_TRUE(g.run_until([&] { return g.hand.motion().current[0] > 50; }));
  const Time touched = g.now;
  ASSERT_TRUE(g.run_until([&] { return !g.hand.is_moving(); }));
  EXPECT_LT(to_seconds(g.now - touched), 0.06);
  EXPECT_TRUE(g.run_until([&] { return g.kind() == Kind::kBlocked; }));
}

TEST(GclDriver, WithoutGaugesStallingEndsIt) {
  VirtualHand g;
  g.hand.set_gauges(false);
  ASSERT_TRUE(g.begin());
  EXPECT_TRUE(g.driver.reading().gauge_fails[0]);
  EXPECT_FALSE(g.driver.reading().gauge_fails[kSpread]) << "it never has one";
  g.plant.put_object(1, 0.5);
  EXPECT_EQ(g.move(g.goal({0.9, 0.9, 0.9, 0}, 0.5)).kind, Kind::kBlocked);
  EXPECT_TRUE(g.driver.reading().blocked[1]);
}

TEST(GclDriver, OpenedClutchIsToldWithBothLinks) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  g.plant.hold_joint(0, 0.5, 1.1);
  EXPECT_EQ(g.move(g.goal({1.5, 0, 0, 0}, 0.5, 60)).kind, Kind::kBlocked);
  EXPECT_TRUE(g.driver.reading().clutch_open[0]);
  EXPECT_NEAR(g.driver.reading().position[0], 1.1, 0.02);
  EXPECT_NEAR(g.driver.reading().joint[0], 0.5, 0.05);
  EXPECT_THAT(g.driver.axis_words(0), HasSubstr("clutch open"));
  // It closes where the finger has gone back, and the flag is taken back.
  g.plant.remove_objects();
  EXPECT_EQ(g.move(g.goal({})).kind, Kind::kReached);
  ASSERT_TRUE(g.run_until([&] { return g.hand.property(0, "BD") == 0; }));
  EXPECT_EQ(g.move(g.goal({1, 0, 0, 0})).kind, Kind::kReached);
  EXPECT_FALSE(g.driver.reading().clutch_open[0]);
}

TEST(GclDriver, StopsWithinFiftyMilliseconds) {
  for (const unsigned fast : {0u, 38400u}) {
    VirtualHand g({.fast_baud = fast});
    ASSERT_TRUE(g.begin());
    for (int i = 0; i < 10; ++i) {
      ASSERT_TRUE(g.begin_to_move()) << i;
      g.run(0.003 * i);
      g.driver.stop(g.now, "stopped by a test");
      const Time told = g.now;
      ASSERT_TRUE(g.run_until([&] { return !g.hand.is_moving(); }));
      EXPECT_LT(to_seconds(g.now - told), 0.05);
      ASSERT_TRUE(g.run_until([&] { return g.driver.is_settled(); }));
      EXPECT_EQ(g.driver.report(g.ticket).kind, Kind::kFailed);
      EXPECT_EQ(g.driver.report(g.ticket).reason, "stopped by a test");
      EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
      ASSERT_EQ(g.move(g.goal({}, 1.5)).kind, Kind::kReached);
    }
    EXPECT_TRUE(g.has_note("stopped"));
    EXPECT_EQ(g.driver.counters().strange, 0u);
  }
}

TEST(GclDriver, StopDuringHiEndsItAndItIsNotBelieved) {
  VirtualHand g;
  g.plant.place(0, 2);
  ASSERT_TRUE(g.connect());
  std::uint64_t ticket = 0;
  ASSERT_EQ(g.driver.initialise(g.now, ticket), "");
  g.run(0.3);
  ASSERT_TRUE(g.hand.is_moving());
  g.driver.stop(g.now, "stopped by a test");
  ASSERT_TRUE(g.run_until([&] { return !g.hand.is_moving(); }));
  ASSERT_TRUE(g.run_until([&] { return g.driver.is_settled(); }));
  EXPECT_EQ(g.driver.report(ticket).reason, "stopped by a test");
  EXPECT_EQ(g.driver.reading().state, DriverState::kUninitialised);
}

TEST(GclDriver, VelocitiesOfAStreamAreFollowedAndEndWithIt) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  const std::array<bool, kAxes> first{true, false, false, false};
  for (int i = 0; i < 20; ++i) {
    ASSERT_EQ(g.driver.command(CommandMode::kVelocity, first, {0.3}, g.now), "");
    g.run(0.05);
  }
  EXPECT_NEAR(g.hand.motion().velocity[0], 0.3, 0.02);
  EXPECT_NEAR(g.hand.motion().position[1], 0, 1e-3);
  EXPECT_EQ(g.lines("1234LOOP"), 1);
  ASSERT_EQ(g.driver.command(CommandMode::kVelocity, first, {-0.3}, g.now), "");
  g.run(0.1);
  EXPECT_LT(g.hand.motion().velocity[0], -0.25);
  ASSERT_TRUE(g.run_until([&] { return !g.hand.is_moving(); }, 0.3)) << "nobody speaks any more";
  EXPECT_TRUE(g.has_problem("no hand command for 0.2 s"));
}

TEST(GclDriver, PositionsOfAStreamAreFollowedInOneRealTimeMode) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  const std::array<bool, kAxes> first{true, false, false, false};
  for (int i = 0; i < 50; ++i) {
    const double where = std::min(0.02 * i, 0.8);
    ASSERT_EQ(g.driver.command(CommandMode::kPosition, first, {where}, g.now), "");
    g.run(0.05);
  }
  EXPECT_NEAR(g.hand.motion().position[0], 0.8, 0.02);
  EXPECT_EQ(g.lines("1234LOOP"), 1);
  ASSERT_TRUE(g.run_until([&] { return !g.hand.is_looping(); }, 2)) << "then it leaves it";
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
}

TEST(GclDriver, VelocityEndsAtTheLimit) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  const std::array<bool, kAxes> first{true, false, false, false};
  for (int i = 0; i < 80; ++i) {
    ASSERT_EQ(g.driver.command(CommandMode::kVelocity, first, {1.5}, g.now), "");
    g.run(0.05);
  }
  EXPECT_LT(g.most[0], 140 * M_PI / 180 + 0.01);
  EXPECT_GT(g.hand.motion().position[0], 2.4);
}

TEST(GclDriver, NewerGoalTakesTheHandOverWithoutAPause) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  ASSERT_TRUE(g.begin_to_move());
  const std::uint64_t first = g.ticket;
  EXPECT_EQ(g.move(g.goal(kThere)).kind, Kind::kReached);
  EXPECT_EQ(g.driver.report(first).kind, Kind::kReplaced);
  EXPECT_EQ(g.lines("1234LOOP"), 1);
}

TEST(GclDriver, LostGripIsTold) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  g.plant.put_object(0, 0.5);
  ASSERT_EQ(g.move(g.goal({1.2, 0, 0, 0}, 0.5)).kind, Kind::kBlocked);
  g.plant.place(0, 0.8);
  ASSERT_TRUE(g.run_until([&] { return !g.driver.reading().is_blocked(); }));
  EXPECT_TRUE(g.has_problem("the grip is lost: F1"));
}

TEST(GclDriver, StatesKeepComingWhileItStands) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  const std::uint64_t before = g.driver.reading().states;
  g.run(10);
  EXPECT_GT(g.driver.reading().states - before, 190u) << "19 a second at 9600 baud";
}

// Who follows the joints gives up after a quarter of a second.
TEST(GclDriver, NeverTellsNothingForLong) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  g.run(1);
  std::uint64_t states = g.driver.reading().states;
  Time told = g.now;
  double longest = 0;  // s
  const auto watch = [&](double seconds) {
    const Time end = g.now + to_time(seconds);
    while (g.now < end) {
      g.run(0.001);
      if (g.driver.reading().states != states) told = g.now;
      states = g.driver.reading().states;
      longest = std::max(longest, to_seconds(g.now - told));
    }
  };
  for (int i = 0; i < 12; ++i) {
    g.plant.remove_objects();
    if (i % 3 == 2) g.plant.hold_joint(0, 0.4, 0.6);
    ASSERT_EQ(g.send(g.goal(i % 2 == 0 ? AxisValues{0.8, 0.5, 0.4, 0.3} : AxisValues{}, 1)), "");
    watch(2.4 + 0.017 * i);
    g.driver.stop(g.now);
    watch(0.5);
  }
  EXPECT_LT(longest, 0.15);
}

TEST(GclDriver, BadOptionsAreRefused) {
  const auto refused = [](const DriverOptions& options) {
    try {
      const Driver driver(options, {}, {}, {});
    } catch (const std::invalid_argument&) {
      return true;
    }
    return false;
  };
  EXPECT_TRUE(refused({.initialisation = Initialisation::kDone}));
  EXPECT_TRUE(refused({.baud = 9601}));
  EXPECT_TRUE(refused({.fast_baud = 115200}));
  EXPECT_TRUE(refused({.velocity_factor = 4}));
  EXPECT_TRUE(refused({.loss_time = 0}));
  DriverOptions upside_down;
  upside_down.limits.upper[1] = -1;
  EXPECT_TRUE(refused(upside_down));
}

}  // namespace
}  // namespace prehend::drivers::barrett::gcl
