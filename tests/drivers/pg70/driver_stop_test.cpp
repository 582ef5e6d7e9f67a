// A stop and a grip are believed when states show them, and not before.

#include <gtest/gtest.h>

#include "tests/drivers/pg70/virtual_gripper.h"

namespace prehend::drivers::pg70 {
namespace {

using Kind = MotionReport::Kind;

std::uint64_t begin_move(VirtualGripper& g, double opening, double speed) {
  std::uint64_t ticket = 0;
  EXPECT_EQ(g.driver.move_to(opening, speed, 0, g.now, ticket), "");
  return ticket;
}

bool ends(VirtualGripper& g, std::uint64_t ticket) {
  return g.run_until([&] { return g.driver.report(ticket).kind != Kind::kRunning; });
}

// It ended the motion, whose jaws ran on from 36 to 5 mm without a word.
TEST(Pg70Grip, SpuriousBlockedDoesNotEndAMotionThatGoesOn) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  const auto ticket = begin_move(g, 0.005, 0.05);
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().opening < 0.036; }));
  g.hear(MotionEnd{Command::kMoveBlocked, static_cast<float>(1e3 * g.driver.reading().opening)});
  g.run(0.1);
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kRunning);
  EXPECT_EQ(g.driver.reading().state, DriverState::kMoving);
  EXPECT_FALSE(g.driver.reading().blocked);
  EXPECT_TRUE(g.has_problem("states show that it goes on"));
  ASSERT_TRUE(ends(g, ticket));
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kReached);
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
}

// With the message two states are enough, without it they must show it for blocked_time.
TEST(Pg70Grip, BlockedMessageMakesTheEndQuicker) {
  double seconds[2] = {};
  for (const bool tells : {false, true}) {
    ModuleOptions options;
    options.impulse_messages = tells;
    DriverOptions slow;
    slow.blocked_time = 1;
    VirtualGripper g(slow, options);
    ASSERT_TRUE(g.connect());
    g.plant.put_object(0.05);
    const auto ticket = begin_move(g, 0.01, 0.05);
    ASSERT_TRUE(g.run_until([&] { return g.module.motion().opening < 0.0501; }));
    const Time touched = g.now;
    ASSERT_TRUE(ends(g, ticket));
    EXPECT_EQ(g.driver.report(ticket).kind, Kind::kBlocked);
    EXPECT_EQ(g.driver.reading().state, DriverState::kHolding);
    seconds[tells] = to_seconds(g.now - touched);
  }
  EXPECT_GT(seconds[false], 1.0);
  EXPECT_LT(seconds[true], 0.2);
}

TEST(Pg70Grip, LostObjectIsNoLongerHeld) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  g.plant.put_object(0.03);
  const auto ticket = begin_move(g, 0.005, 0.03);
  ASSERT_TRUE(ends(g, ticket));
  ASSERT_EQ(g.driver.reading().state, DriverState::kHolding);
  g.run(2);
  ASSERT_EQ(g.driver.reading().state, DriverState::kHolding);
  g.plant.put_object(std::nullopt);  // the module goes on pressing, so the jaws run
  ASSERT_TRUE(g.run_until([&] { return !g.driver.reading().blocked; }, 0.3));
  EXPECT_TRUE(g.has_problem("the grip is lost: the jaws went from 30.0 mm to 2"));
  EXPECT_EQ(g.driver.reading().state, DriverState::kMoving);
  const auto stops = g.module.stops();
  g.run(1);
  EXPECT_GT(g.module.stops(), stops);  // the motion had ended: nobody asked for this one
  EXPECT_GT(g.module.motion().opening, 0.006);
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
}

TEST(Pg70Grip, JawsThatPressNoMoreHoldNothing) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  g.plant.put_object(0.03);
  ASSERT_TRUE(ends(g, begin_move(g, 0.005, 0.05)));
  ASSERT_EQ(g.driver.reading().state, DriverState::kHolding);
  g.module.set_mute(true);
  for (int i = 0; i < 30; ++i) {
    g.hear(State{30.F, 0.F, 0.F, kReferenced | kMoveEnded, 0});
    g.run(0.02);
  }
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
  EXPECT_FALSE(g.driver.reading().blocked);
  EXPECT_TRUE(g.has_problem("the grip is lost: nothing presses any more"));
}

// Where the module does not tell its current while it holds.
TEST(Pg70Grip, CurrentIsNotLookedAtWhenToldSo) {
  DriverOptions options;
  options.holding_current = 0;
  VirtualGripper g(options);
  ASSERT_TRUE(g.connect());
  g.plant.put_object(0.03);
  ASSERT_TRUE(ends(g, begin_move(g, 0.005, 0.05)));
  g.module.set_mute(true);
  for (int i = 0; i < 30; ++i) {
    g.hear(State{30.F, 0.F, 0.F, kReferenced | kMoveEnded, 0});
    g.run(0.02);
  }
  EXPECT_EQ(g.driver.reading().state, DriverState::kHolding);
  options.holding_current = 1.1;
  EXPECT_THROW(VirtualGripper{options}, std::invalid_argument);
}

TEST(Pg70Stop, UnansweredStopOfMovingJawsBecomesAFastStop) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  const auto ticket = begin_move(g, 0.0, 0.02);
  g.run(0.3);
  ASSERT_TRUE(g.module.is_moving());
  g.swallowed = {Command::kStop};
  g.driver.stop(g.now, "stopped by somebody");
  EXPECT_EQ(g.driver.report(ticket).reason, "stopped by somebody");
  const Time asked = g.now;
  ASSERT_TRUE(g.run_until([&] { return !g.module.is_moving(); }, 2));
  EXPECT_LE(to_seconds(g.now - asked), 4 * g.driver.options().reply_time);
  EXPECT_TRUE(g.has_problem("CMD STOP is not answered: CMD FAST STOP is sent"));
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kFault; }, 1));
  EXPECT_EQ(g.driver.reading().error_code, static_cast<int>(ErrorCode::kFastStop));
  EXPECT_FALSE(g.driver.is_stopping());
}

TEST(Pg70Stop, AnsweredStopThatDoesNotStopBecomesAFastStop) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  begin_move(g, 0.0, 0.02);
  g.run(0.3);
  g.swallowed = {Command::kStop};
  g.driver.stop(g.now);
  g.hear(Confirmation{Command::kStop});
  g.run(0.5);
  EXPECT_TRUE(g.module.is_moving());
  EXPECT_TRUE(g.driver.is_stopping());
  EXPECT_FALSE(g.has_note("stopped at"));
  g.run(0.5);
  EXPECT_FALSE(g.module.is_moving());
  EXPECT_TRUE(g.has_problem("moves on although CMD STOP was answered: CMD FAST STOP is sent"));
}

TEST(Pg70Stop, FastStopIsRepeatedUntilTheModuleShowsIt) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  begin_move(g, 0.0, 0.02);
  g.run(0.3);
  g.swallowed = {Command::kFastStop};
  g.driver.fast_stop(g.now);
  g.run(0.5);
  EXPECT_TRUE(g.module.is_moving());
  g.swallowed.clear();
  g.run(0.2);
  EXPECT_FALSE(g.module.is_moving());
  EXPECT_EQ(g.driver.reading().state, DriverState::kFault);
}

TEST(Pg70Stop, IsToldWhenStatesShowIt) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  begin_move(g, 0.0, 0.08);
  g.run(0.5);
  g.driver.stop(g.now);
  EXPECT_TRUE(g.driver.is_stopping());
  EXPECT_FALSE(g.driver.is_settled());
  g.run(0.02);
  EXPECT_TRUE(g.driver.reading().moving);  // they brake, whatever the status bit says
  EXPECT_FALSE(g.has_note("stopped at"));
  ASSERT_TRUE(g.run_until([&] { return g.driver.is_settled(); }, 1));
  EXPECT_LT(std::abs(g.module.motion().velocity), 6e-3);
  EXPECT_TRUE(g.has_note("stopped at "));
  EXPECT_TRUE(g.problems.empty());
}

// A held part would fall by a fast stop.
TEST(Pg70Stop, SilenceWhileItHoldsIsNoReasonForAFastStop) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  g.plant.put_object(0.03);
  ASSERT_TRUE(ends(g, begin_move(g, 0.005, 0.05)));
  ASSERT_EQ(g.driver.reading().state, DriverState::kHolding);
  g.module.set_mute(true);
  g.run(2);
  EXPECT_EQ(g.driver.reading().state, DriverState::kLost);
  g.module.set_mute(false);
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().state > DriverState::kFault; }, 1));
  const auto fast = encode(PlainRequest{Command::kFastStop});
  EXPECT_EQ(std::count(g.sent.begin(), g.sent.end(), fast), 0);
}

}  // namespace
}  // namespace prehend::drivers::pg70
