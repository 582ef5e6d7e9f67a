// What the BH8-262's driver makes of a hand and of a line that fail.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/drivers/barrett/gcl/virtual_hand.h"

namespace prehend::drivers::barrett::gcl {
namespace {

using ::testing::HasSubstr;
using Kind = MotionReport::Kind;

TEST(GclFaults, LateFirstPromptIsWaitedFor) {
  VirtualHand g;
  g.hand.set_mute(true);
  g.driver.connected(g.now);
  g.run(15);
  EXPECT_EQ(g.driver.reading().state, DriverState::kConnecting);
  EXPECT_FALSE(g.driver.reading().answers[0]);
  g.hand.set_mute(false);
  EXPECT_TRUE(g.is_in(DriverState::kUninitialised));
}

TEST(GclFaults, HandThatBootsIsWaitedFor) {
  VirtualHand g;
  g.hand.reboot(g.now);
  g.driver.connected(g.now);
  EXPECT_TRUE(g.is_in(DriverState::kUninitialised));
}

TEST(GclFaults, PromptThatIsMissingIsAskedForByCtrlC) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  const auto aborts = g.hand.aborts();
  g.hand.set_prompts(false);
  ASSERT_TRUE(g.run_until([&] { return g.hand.aborts() > aborts; }, 3));
  g.hand.set_prompts(true);
  EXPECT_TRUE(g.settles());
  EXPECT_EQ(g.move(g.goal(kThere)).kind, Kind::kReached);
}

TEST(GclFaults, PromptThatIsLateMakesItLostUntilItComes) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  g.hand.set_delay(5);
  ASSERT_TRUE(g.is_in(DriverState::kLost, 5));
  EXPECT_THAT(g.send(g.goal(kThere)), HasSubstr("answers are missing"));
  g.run(8);
  g.hand.set_delay(0);
  ASSERT_TRUE(g.is_in(DriverState::kStanding, 30)) << ::testing::PrintToString(g.problems);
  EXPECT_EQ(g.move(g.goal(kThere)).kind, Kind::kReached);
}

TEST(GclFaults, LostByteOfAnEchoIsAskedAgain) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  for (int i = 0; i < 5; ++i) {
    g.hand.lose_echo();
    g.run(1);
  }
  EXPECT_GE(g.driver.counters().strange, 5u);
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
  EXPECT_EQ(g.driver.counters().connections, 1u);
}

TEST(GclFaults, DamagedBlocksPauseAMotionForAMoment) {
  for (const bool is_short : {false, true}) {
    VirtualHand g;
    ASSERT_TRUE(g.begin());
    ASSERT_TRUE(g.begin_to_move(0.5));
    if (is_short) {
      g.hand.shorten_blocks(1);
    } else {
      g.hand.garble_blocks(1);  // a position
    }
    ASSERT_TRUE(g.run_until([&] { return g.kind() != Kind::kRunning; }));
    EXPECT_EQ(g.kind(), Kind::kReached) << g.driver.report(g.ticket).reason;
    EXPECT_GT(g.driver.counters().strange + g.driver.counters().unanswered, 0u);
  }
}

// One block of too much strain is a byte that came to harm, not a grip.
TEST(GclFaults, WrongStrainOfOneBlockEndsNothing) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  ASSERT_TRUE(g.begin_to_move(0.5));
  g.hand.garble_blocks(1, 1);
  ASSERT_TRUE(g.run_until([&] { return g.kind() != Kind::kRunning; }));
  EXPECT_EQ(g.kind(), Kind::kReached);
}

// A wrong byte of a position has no checksum: it is no position that a motor can have come to.
TEST(GclFaults, WrongPositionMovesNothingElsewhere) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  ASSERT_TRUE(g.begin_to_move(0.5));
  g.hand.garble_blocks(2);
  ASSERT_TRUE(g.run_until([&] { return g.kind() != Kind::kRunning; }));
  EXPECT_EQ(g.kind(), Kind::kReached);
  for (std::size_t i = 0; i < kSpread; ++i) EXPECT_LT(g.most[i], 2.02);
}

TEST(GclFaults, LineThatKeepsHarmingBlocksEndsTheMotion) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  ASSERT_TRUE(g.begin_to_move());
  g.hand.shorten_blocks(1000);
  ASSERT_TRUE(g.run_until([&] { return g.kind() != Kind::kRunning; }));
  EXPECT_EQ(g.kind(), Kind::kFailed);
  EXPECT_TRUE(g.run_until([&] { return !g.hand.is_moving(); }, 0.1));
  g.hand.shorten_blocks(0);
  ASSERT_TRUE(g.settles());
  EXPECT_EQ(g.move(g.goal(kThere)).kind, Kind::kReached);
}

TEST(GclFaults, OverheatingInRealTimeModeEndsTheMotion) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  ASSERT_TRUE(g.begin_to_move());
  g.hand.set_temperature(70);
  ASSERT_TRUE(g.run_until([&] { return g.kind() != Kind::kRunning; }));
  EXPECT_THAT(g.driver.report(g.ticket).reason, HasSubstr("ERR 8192 over-temperature"));
  EXPECT_FALSE(g.hand.is_moving());
  EXPECT_FALSE(g.hand.is_looping());
  ASSERT_TRUE(g.settles());
  EXPECT_THAT(g.move(g.goal(kThere)).reason, HasSubstr("over-temperature"));
  ASSERT_TRUE(g.settles());
  ASSERT_TRUE(g.run_until([&] { return *g.driver.reading().temperature > 69; }));
  g.hand.set_temperature(50);
  EXPECT_EQ(g.move(g.goal(kThere)).kind, Kind::kReached);
}

TEST(GclFaults, AnyErrInRealTimeModeMeansThatItWasLeft) {
  for (const int code : {16, 32, 8192, 16384}) {
    VirtualHand g;
    ASSERT_TRUE(g.begin());
    ASSERT_TRUE(g.begin_to_move());
    g.hand.set_refusal(code);
    ASSERT_TRUE(g.run_until([&] { return !g.hand.is_looping(); }));
    ASSERT_TRUE(g.run_until([&] { return g.kind() != Kind::kRunning; }));
    EXPECT_THAT(g.driver.report(g.ticket).reason, HasSubstr("ERR " + std::to_string(code)));
    g.hand.set_refusal(0);
    ASSERT_TRUE(g.settles()) << code;
    EXPECT_EQ(g.move(g.goal(kThere)).kind, Kind::kReached) << code;
  }
}

TEST(GclFaults, ResetInTheMiddleNeedsHiAgain) {
  for (const bool moves : {false, true}) {
    VirtualHand g;
    ASSERT_TRUE(g.begin());
    if (moves) {
      ASSERT_TRUE(g.begin_to_move());
    }
    g.hand.reboot(g.now);
    ASSERT_TRUE(g.is_in(DriverState::kUninitialised, 10)) << moves;
    EXPECT_EQ(g.kind() == Kind::kFailed, moves);
    const auto count = g.hand.moves();
    g.run(5);
    EXPECT_EQ(g.hand.moves(), count) << "nothing is resumed, nor initialised";
    EXPECT_THAT(g.send(g.goal(kThere)), HasSubstr("/hand/initialise"));
    std::uint64_t ticket = 0;
    ASSERT_EQ(g.driver.initialise(g.now, ticket), "");
    ASSERT_TRUE(g.is_in(DriverState::kStanding, 25));
    EXPECT_EQ(g.move(g.goal(kThere)).kind, Kind::kReached);
  }
}

TEST(GclFaults, RateThatAResetTookBackIsFoundAgain) {
  VirtualHand g({.fast_baud = 38400});
  ASSERT_TRUE(g.begin());
  ASSERT_EQ(g.hand.baud(), 38400u);
  g.hand.reboot(g.now);
  ASSERT_EQ(g.hand.baud(), kBaud);
  ASSERT_TRUE(g.is_in(DriverState::kUninitialised, 20)) << ::testing::PrintToString(g.problems);
  EXPECT_EQ(g.driver.baud(), g.hand.baud());
}

// A driver that begins anew finds the hand at the rate that the one before had agreed on.
TEST(GclFaults, DriverThatBeginsAnewFindsTheRate) {
  VirtualHand g({.fast_baud = 38400});
  ASSERT_TRUE(g.begin());
  ASSERT_TRUE(g.begin_to_move());
  g.begin_driver_anew();
  ASSERT_TRUE(g.run_until([&] { return !g.hand.is_moving(); }, 1));
  ASSERT_TRUE(g.is_in(DriverState::kStanding, 10));
  EXPECT_EQ(g.hand.baud(), 38400u);
  const auto count = g.hand.moves();
  g.run(2);
  EXPECT_EQ(g.hand.moves(), count);
}

TEST(GclFaults, RateThatTheHandRefusesIsLeft) {
  VirtualHand g({.fast_baud = 38400});
  g.hand.set_deaf_to("PSET");
  g.driver.connected(g.now);
  g.run(4);
  g.hand.set_deaf_to({});
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().state > DriverState::kFault; }, 20));
}

TEST(GclFaults, MissingMotorIsAFault) {
  VirtualHand g;
  g.driver.connected(g.now);
  ASSERT_TRUE(g.run_until([&] { return g.lines("FGET S") > 0; }));
  const std::string answer = "FGET S\n\r0 2 0 0\n\r=> ";
  g.is_cut = true;
  g.driver.receive({reinterpret_cast<const std::uint8_t*>(answer.data()), answer.size()}, g.now);
  EXPECT_EQ(g.driver.reading().state, DriverState::kFault);
  EXPECT_THAT(g.send(g.goal(kThere)), HasSubstr("F2 of the hand: ERR 2 a motor is missing"));
}

TEST(GclFaults, FirmwareThatIsAnotherIsAFaultWithItsMend) {
  VirtualHand g({.firmware = Firmware::k4_4}, {.firmware = Firmware::k4_3});
  g.driver.connected(g.now);
  ASSERT_TRUE(g.is_in(DriverState::kFault));
  EXPECT_THAT(g.driver.reading().problem, HasSubstr("firmware:="));
  EXPECT_EQ(g.hand.moves(), 0u);
}

TEST(GclFaults, CutLineIsToldAndMotionRunsOnUntilItStalls) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  ASSERT_TRUE(g.begin_to_move());
  g.driver.disconnected("the line is gone");
  EXPECT_EQ(g.driver.reading().state, DriverState::kDisconnected);
  EXPECT_TRUE(g.has_problem("the motion goes on until it stalls"));
  EXPECT_EQ(g.driver.report(g.ticket).reason, "the line is gone");
  // A new connection begins with Ctrl-C.
  g.driver.connected(g.now);
  ASSERT_TRUE(g.run_until([&] { return !g.hand.is_moving(); }, 0.3));
}

TEST(GclFaults, SilenceInRealTimeModeIsAnsweredByCtrlC) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  ASSERT_TRUE(g.begin_to_move());
  g.hand.set_mute(true);
  ASSERT_TRUE(g.run_until([&] { return !g.hand.is_moving(); }, 0.3));
  ASSERT_TRUE(g.is_in(DriverState::kLost, 5));
  EXPECT_EQ(g.kind(), Kind::kFailed);
}

TEST(GclFaults, HandThatMovesOnAfterCtrlCIsSwitchedOff) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  ASSERT_TRUE(g.begin_to_move(0.2));
  g.hand.set_running_on(true);
  g.driver.stop(g.now);
  ASSERT_TRUE(g.run_until([&] { return g.lines("T\r") > 0; }, 3));
  EXPECT_TRUE(g.has_problem("motors are told to switch off"));
  ASSERT_TRUE(g.run_until([&] { return g.driver.is_settled(); }));
  EXPECT_FALSE(g.hand.is_moving());
}

// Ctrl-C alone, or with ERR 16384: either is tolerated.
TEST(GclFaults, CtrlCMaySayNothing) {
  VirtualHand g({}, {.prints_abort = false});
  ASSERT_TRUE(g.begin());
  EXPECT_EQ(g.move(g.goal(kThere)).kind, Kind::kReached);
  ASSERT_TRUE(g.begin_to_move());
  g.driver.stop(g.now);
  EXPECT_TRUE(g.run_until([&] { return g.driver.is_settled(); }));
}

TEST(GclFaults, HandThatMissesAByteOfABlockStillStops) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  ASSERT_TRUE(g.begin_to_move());
  const std::uint8_t half[] = {'C', 10, 10};
  g.hand.receive(half, g.now);  // now every byte is taken for another
  g.driver.stop(g.now);
  const Time told = g.now;
  ASSERT_TRUE(g.run_until([&] { return !g.hand.is_moving() && !g.hand.is_looping(); }));
  EXPECT_LT(to_seconds(g.now - told), 0.3);
}

TEST(GclFaults, RefusedHiIsToldAndNotBelieved) {
  VirtualHand g;
  ASSERT_TRUE(g.connect());
  std::uint64_t ticket = 0;
  g.hand.set_temperature(80);
  ASSERT_EQ(g.driver.initialise(g.now, ticket), "");
  ASSERT_TRUE(g.run_until([&] { return g.driver.report(ticket).kind == Kind::kFailed; }));
  EXPECT_THAT(g.driver.report(ticket).reason, HasSubstr("over-temperature"));
  ASSERT_TRUE(g.is_in(DriverState::kUninitialised));
}

// Whatever comes of it. HI has a speed of its own.
void initialise(VirtualHand& g) {
  const AxisValues before = g.fastest;
  g.driver.initialise(g.now, g.ticket);
  g.run(25);
  g.fastest = before;
}

// 10,000 bytes or blocks lost, doubled, wrong and late, with reboots and pulled plugs among them:
// whatever it is told, the hand stays within its limits, and is whole afterwards.
TEST(GclFaults, BadLineNeverMakesItLeaveItsLimits) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    VirtualHand g({.fast_baud = seed == 3 ? 38400u : 0u});
    ASSERT_TRUE(g.begin());
    const LineFaults faults{.dropped = 0.004,
                            .duplicated = 0.002,
                            .corrupted = 0.004,
                            .late = 0.01,
                            .delay = to_time(0.02)};
    g.to_hand.set_faults(faults);
    g.from_hand.set_faults(faults);
    g.fastest.fill(0);  // HI has a speed of its own
    std::mt19937_64 random(seed);
    for (int i = 0; g.to_hand.harmed() + g.from_hand.harmed() < 3400; ++i) {
      g.send(g.goal(i % 2 == 0 ? AxisValues{1.5, 1.2, 1, 0.5} : AxisValues{}, 0.7));
      g.run(3);
      switch (random() % 12) {
        case 0:
          g.driver.disconnected("pulled");
          g.run(0.3);
          g.driver.connected(g.now);
          break;
        case 1:
          g.hand.reboot(g.now);
          break;
        case 2:
        case 3:
          g.driver.stop(g.now);
          break;
        default:
          break;
      }
      if (g.driver.reading().state == DriverState::kUninitialised) initialise(g);
    }
    // The line has no checksums: a harmed LCV is obeyed until the next block, and says 127 counts
    // per 10 ms at most.
    constexpr double kMostOfLcv[kAxes] = {1.8, 1.8, 1.8, 12.8};  // rad/s
    for (std::size_t i = 0; i < kAxes; ++i) EXPECT_LT(g.fastest[i], kMostOfLcv[i]) << i;
    for (std::size_t i = 0; i < kSpread; ++i) {
      EXPECT_LT(g.most[i], 140 * M_PI / 180 + 0.02);
      EXPECT_GT(g.least[i], -0.01);
    }
    g.to_hand.set_faults({});
    g.from_hand.set_faults({});
    ASSERT_TRUE(g.run_until([&] { return g.driver.is_settled(); }, 30));
    ASSERT_TRUE(
        g.run_until([&] { return g.driver.reading().state >= DriverState::kUninitialised; }, 30));
    for (int i = 0; i < 3 && g.driver.reading().state != DriverState::kStanding; ++i) initialise(g);
    ASSERT_EQ(g.driver.reading().state, DriverState::kStanding)
        << g.driver.report(g.ticket).reason << "; "
        << (g.problems.empty() ? "" : g.problems.back());
    EXPECT_EQ(g.move(g.goal(kThere)).kind, Kind::kReached);
  }
}

}  // namespace
}  // namespace prehend::drivers::barrett::gcl
