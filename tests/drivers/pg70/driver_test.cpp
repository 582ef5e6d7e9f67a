// The driver's state machine against the emulated module, in simulated time.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/drivers/pg70/virtual_gripper.h"

namespace prehend::drivers::pg70 {
namespace {

using Kind = MotionReport::Kind;

Kind run_to_end(VirtualGripper& g, std::uint64_t ticket, double seconds = 10) {
  g.run_until([&] { return g.driver.report(ticket).kind != Kind::kRunning; }, seconds);
  return g.driver.report(ticket).kind;
}

std::uint64_t move(VirtualGripper& g, double opening, double speed = 0.05) {
  std::uint64_t ticket = 0;
  EXPECT_EQ(g.driver.move_to(opening, speed, 0, g.now, ticket), "");
  return ticket;
}

TEST(Pg70Driver, StopIsTheFirstThingItSays) {
  VirtualGripper g;
  EXPECT_EQ(g.driver.reading().state, DriverState::kDisconnected);
  ASSERT_TRUE(g.connect());
  ASSERT_FALSE(g.sent.empty());
  EXPECT_EQ(g.sent.front(), encode(PlainRequest{Command::kStop}));
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
  EXPECT_NEAR(g.driver.reading().opening, 0.069, 1e-6);
  EXPECT_TRUE(g.driver.reading().referenced);
}

TEST(Pg70Driver, StatesComeAtTheirRate) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  const auto before = g.driver.reading().states;
  g.run(2);
  EXPECT_NEAR(static_cast<double>(g.driver.reading().states - before), 100, 3);
}

TEST(Pg70Driver, MovesToAnOpeningWithinItsLimits) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  for (const double opening : {0.02, 0.05, 0.0, 0.069, 0.0301}) {
    EXPECT_EQ(run_to_end(g, move(g, opening)), Kind::kReached) << opening;
    EXPECT_NEAR(g.driver.reading().opening, opening, 3e-4);
    EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
  }
  EXPECT_LE(g.fastest, 0.0501);
  EXPECT_EQ(run_to_end(g, move(g, 0.0, 10)), Kind::kReached);  // cut to the maximum
  EXPECT_LE(g.fastest, 0.0831);
  EXPECT_TRUE(g.problems.empty());
}

TEST(Pg70Driver, BlockedByWhatItGrips) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  g.plant.put_object(0.03);
  EXPECT_EQ(run_to_end(g, move(g, 0.01)), Kind::kBlocked);
  EXPECT_EQ(g.driver.reading().state, DriverState::kHolding);
  EXPECT_TRUE(g.driver.reading().blocked);
  EXPECT_NEAR(g.driver.reading().opening, 0.03, 1e-4);
  g.run(0.1);
  EXPECT_NEAR(g.driver.reading().current, -2.0, 1e-3);  // presses with the nominal current
  EXPECT_EQ(run_to_end(g, move(g, 0.06)), Kind::kReached);
  EXPECT_FALSE(g.driver.reading().blocked);
}

// Only states can tell that it stands; a computer that was held up has seen none.
TEST(Pg70Driver, BeingHeldUpIsNotTakenForABlockedGripper) {
  DriverOptions options;
  options.loss_time = 5;
  VirtualGripper g(options);
  ASSERT_TRUE(g.connect());
  const auto ticket = move(g, 0.01);
  const auto say = [&](const Response& response) {
    g.now += std::chrono::milliseconds(2);
    g.driver.receive({Direction::kResponse, encode(response)}, g.now);
    g.driver.update(g.now);
  };
  const State standing{69.f, 0.f, 0.f, kReferenced, 0};
  say(standing);  // sent before the command came
  say(MoveStarted{Command::kMovePosition, 1.f});
  g.now += std::chrono::seconds(1);
  g.driver.update(g.now);
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kRunning);
  say(standing);
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kRunning);
  g.now += std::chrono::seconds(1);
  say(standing);  // it stood at both ends of this second
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kBlocked);
  EXPECT_NE(g.driver.reading().state, DriverState::kHolding);  // without a current nothing presses
}

TEST(Pg70Driver, EndsOfMotionsAreSeenWithoutImpulseMessages) {
  ModuleOptions quiet;
  quiet.impulse_messages = false;
  quiet.tells_duration = false;
  VirtualGripper g({}, quiet);
  ASSERT_TRUE(g.connect());
  EXPECT_EQ(run_to_end(g, move(g, 0.02)), Kind::kReached);
  EXPECT_EQ(run_to_end(g, move(g, 0.02)), Kind::kReached);  // it is there already
  g.plant.put_object(0.015);
  EXPECT_EQ(run_to_end(g, move(g, 0.0)), Kind::kBlocked);
}

class Pg70Velocity : public ::testing::TestWithParam<bool> {};

TEST_P(Pg70Velocity, WatchdogStopsIt) {
  DriverOptions options;
  options.velocity_as_position = GetParam();
  VirtualGripper g(options);
  ASSERT_TRUE(g.connect());
  const Time begin = g.now;
  while (to_seconds(g.now - begin) < 0.5) {
    EXPECT_EQ(g.driver.command(MotionMode::kVelocity, -0.02, 1.0, g.now), "");
    g.run(0.02);
  }
  EXPECT_TRUE(g.driver.reading().moving);
  EXPECT_NEAR(g.driver.reading().velocity, -0.02, 1e-3);
  const Time last = g.now;
  ASSERT_TRUE(g.run_until([&] { return !g.module.is_moving(); }, 1));
  EXPECT_LE(to_seconds(g.now - last), 2 * options.watchdog);
  EXPECT_TRUE(g.has_problem("no gripper command for 0.2 s while moving: CMD STOP"));
}

TEST_P(Pg70Velocity, EndsWithinTheRangeWithoutAFault) {
  DriverOptions options;
  options.velocity_as_position = GetParam();
  VirtualGripper g(options);
  ASSERT_TRUE(g.connect());
  for (const double speed : {-0.08, 0.08, -1e9, 1e9, -0.001}) {
    for (int i = 0; i < 150; ++i) {
      ASSERT_EQ(g.driver.command(MotionMode::kVelocity, speed, 0, g.now), "");
      g.run(0.02);
    }
    EXPECT_EQ(g.driver.reading().error_code, 0);
  }
  EXPECT_GE(g.least, -1e-4);
  EXPECT_LE(g.most, 0.0691);
  EXPECT_LE(g.fastest, 0.0831);
}

TEST_P(Pg70Velocity, PressesOnWhatBlocksItAndFollowsWhenItGivesWay) {
  DriverOptions options;
  options.velocity_as_position = GetParam();
  VirtualGripper g(options);
  ASSERT_TRUE(g.connect());
  g.plant.put_object(0.04);
  const auto close_for = [&](double seconds) {
    for (double t = 0; t < seconds; t += 0.02) {
      ASSERT_EQ(g.driver.command(MotionMode::kVelocity, -0.02, 1.5, g.now), "");
      g.run(0.02);
    }
  };
  close_for(2.5);
  EXPECT_EQ(g.driver.reading().state, DriverState::kHolding);
  EXPECT_NEAR(g.module.motion().current, -1.5, 1e-3);
  g.run(1.0);  // no more commands: it holds, the watchdog is about motion
  EXPECT_NEAR(g.module.motion().current, -1.5, 1e-3);
  g.plant.put_object(0.035);
  close_for(1.5);
  EXPECT_NEAR(g.driver.reading().opening, 0.035, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(BothWays, Pg70Velocity, ::testing::Bool());

TEST(Pg70Driver, PressesWithACurrent) {
  for (const bool grip : {false, true}) {
    DriverOptions options;
    options.current_as_grip = grip;
    VirtualGripper g(options);
    ASSERT_TRUE(g.connect());
    g.plant.put_object(0.05);
    for (int i = 0; i < 100; ++i) {
      ASSERT_EQ(g.driver.command(MotionMode::kCurrent, -3.0, 0, g.now), "");
      g.run(0.02);
    }
    EXPECT_EQ(g.driver.reading().state, DriverState::kHolding);
    EXPECT_NEAR(g.driver.reading().current, -3.0, 1e-3);
    ASSERT_EQ(g.driver.command(MotionMode::kCurrent, -100, 0, g.now), "");
    g.run(0.1);
    EXPECT_NEAR(g.driver.reading().current, -6.5, 1e-3);  // cut to the maximum
  }
}

TEST(Pg70Driver, RefusesWhatMakesNoSense) {
  VirtualGripper g;
  EXPECT_EQ(g.driver.command(MotionMode::kVelocity, -0.01, 0, g.now),
            "the gripper is not connected");
  ASSERT_TRUE(g.connect());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  std::uint64_t ticket = 0;
  EXPECT_EQ(g.driver.move_to(0.02, 0, 0, g.now, ticket), "speed must be positive");
  EXPECT_EQ(g.driver.move_to(0.02, nan, 0, g.now, ticket), "speed must be positive");
  EXPECT_EQ(g.driver.move_to(0.07, 0.01, 0, g.now, ticket), "opening 0.07 m is outside 0..0.069 m");
  EXPECT_EQ(g.driver.move_to(-1e-3, 0.01, 0, g.now, ticket),
            "opening -0.001 m is outside 0..0.069 m");
  for (const double bad : {nan, infinity, -infinity}) {
    EXPECT_NE(g.driver.move_to(bad, 0.01, 0, g.now, ticket), "");
    EXPECT_NE(g.driver.move_to(0.02, 0.01, bad, g.now, ticket), "");
    EXPECT_NE(g.driver.command(MotionMode::kVelocity, bad, 0, g.now), "");
    EXPECT_NE(g.driver.command(MotionMode::kCurrent, bad, 0, g.now), "");
  }
  EXPECT_NE(g.driver.move_to(0.02, 0.01, -1, g.now, ticket), "");
  g.run(0.5);
  EXPECT_EQ(g.module.motions(), 0u);
  DriverOptions options;
  options.watchdog = nan;
  EXPECT_THROW(VirtualGripper{options}, std::invalid_argument);
  options = {};
  options.limits.nominal_current = 7;
  EXPECT_THROW(VirtualGripper{options}, std::invalid_argument);
}

TEST(Pg70Driver, AnotherCommandTakesTheMotionOver) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  const std::uint64_t first = move(g, 0.0);
  g.run(0.2);
  const std::uint64_t second = move(g, 0.06);
  EXPECT_EQ(g.driver.report(first).kind, Kind::kReplaced);
  g.run(0.1);
  EXPECT_EQ(g.driver.command(MotionMode::kVelocity, 0.01, 0, g.now), "");
  EXPECT_EQ(g.driver.report(second).kind, Kind::kReplaced);
  g.driver.stop(g.now);
  ASSERT_TRUE(g.run_until([&] { return !g.module.is_moving(); }, 0.1));
}

TEST(Pg70Driver, UnreferencedGripperIsReferencedFirst) {
  ModuleOptions fresh;
  fresh.referenced = false;
  VirtualGripper g({}, fresh);
  g.driver.connected(g.now);
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kUnreferenced; }));
  std::uint64_t ticket = 0;
  EXPECT_NE(g.driver.move_to(0.02, 0.05, 0, g.now, ticket).find("not referenced"),
            std::string::npos);
  EXPECT_EQ(g.driver.reference(g.now), "");
  g.run(0.1);
  EXPECT_EQ(g.driver.reading().state, DriverState::kReferencing);
  EXPECT_NE(g.driver.move_to(0.02, 0.05, 0, g.now, ticket), "");
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kStanding; }));
  EXPECT_EQ(run_to_end(g, move(g, 0.02)), Kind::kReached);
}

TEST(Pg70Driver, EveryErrorStopsItAndIsAcknowledged) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  int count = 0;
  for (const CodeText& text : error_texts()) {
    if (text.code == 0) continue;
    SCOPED_TRACE(text.name);
    g.problems.clear();
    const std::uint64_t ticket = move(g, g.module.motion().opening > 0.03 ? 0.0 : 0.069);
    ++count;
    g.run(0.1);
    g.module.fail(static_cast<ErrorCode>(text.code), false, g.now);
    ASSERT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kFault; }, 0.1));
    EXPECT_EQ(g.driver.reading().error_code, text.code);
    EXPECT_EQ(g.driver.report(ticket).kind, Kind::kFailed);
    EXPECT_EQ(g.driver.report(ticket).reason, describe_code(text.code));
    EXPECT_TRUE(g.has_problem(text.name));
    g.run(0.1);
    ASSERT_TRUE(g.driver.detailed_error());
    EXPECT_EQ(g.driver.detailed_error()->code, text.code);
    EXPECT_NE(g.driver.command(MotionMode::kVelocity, -0.01, 0, g.now).find("acknowledge"),
              std::string::npos);
    EXPECT_EQ(g.driver.acknowledge(g.now), "");
    ASSERT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kStanding; }, 1));
    EXPECT_EQ(g.problems.size(), 1u);  // told once, not with each state
  }
  EXPECT_EQ(count, 32);
}

TEST(Pg70Driver, AcknowledgedErrorWhoseCausePersistsIsAWarning) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  g.module.fail(ErrorCode::kMotorVoltageLow, true, g.now);
  g.run(0.1);
  EXPECT_EQ(g.driver.reading().state, DriverState::kFault);
  g.driver.acknowledge(g.now);
  g.run(0.1);
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
  EXPECT_EQ(g.driver.reading().warning_code, 0x74);
  EXPECT_TRUE(g.has_problem("warning: ERROR MOTOR VOLTAGE LOW"));
  g.module.mend(g.now);
  g.run(0.1);
  EXPECT_EQ(g.driver.reading().warning_code, 0);
}

TEST(Pg70Driver, FastStopIsAFaultToAcknowledge) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  move(g, 0.0);
  g.run(0.2);
  g.driver.fast_stop(g.now);
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kFault; }, 0.1));
  EXPECT_EQ(g.driver.reading().error_code, 0xD9);
  EXPECT_FALSE(g.module.is_moving());
}

TEST(Pg70Driver, LostRepliesStopItWithinTwoWatchdogPeriods) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  const std::uint64_t ticket = move(g, 0.0, 0.02);
  g.run(0.3);
  ASSERT_TRUE(g.module.is_moving());
  const auto stops = g.module.stops();
  g.module.set_mute(true);
  const Time lost = g.now;
  ASSERT_TRUE(g.run_until([&] { return g.module.stops() > stops && !g.module.is_moving(); }, 2));
  EXPECT_LE(to_seconds(g.now - lost), 2 * g.driver.options().watchdog);
  EXPECT_EQ(g.driver.reading().state, DriverState::kLost);
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kFailed);
  EXPECT_TRUE(g.has_problem("no state from the module"));
  EXPECT_NE(g.driver.command(MotionMode::kVelocity, -0.01, 0, g.now), "");

  g.run(3);
  EXPECT_TRUE(g.has_problem("CMD FAST STOP is sent"));
  g.module.set_mute(false);
  const auto motions = g.module.motions();
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kFault; }, 2));
  g.driver.acknowledge(g.now);
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kStanding; }, 2));
  g.run(1);
  EXPECT_EQ(g.module.motions(), motions);  // nothing resumes
  EXPECT_EQ(run_to_end(g, move(g, 0.03)), Kind::kReached);
}

TEST(Pg70Driver, LinkDownIsReportedAtOnceAndNothingResumes) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  const std::uint64_t ticket = move(g, 0.0, 0.01);
  g.run(0.3);
  g.is_cut = true;
  g.driver.link_event({LinkEvent::Kind::kDown, "bus-off"}, g.now);
  EXPECT_EQ(g.driver.reading().state, DriverState::kDisconnected);
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kFailed);
  EXPECT_TRUE(g.has_problem("nothing can be sent"));
  g.run(1);
  EXPECT_NE(g.driver.command(MotionMode::kVelocity, -0.01, 0, g.now), "");
  g.is_cut = false;  // it comes back without a word, as an interface does
  const auto motions = g.module.motions();
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kStanding; }, 2));
  EXPECT_FALSE(g.module.is_moving());
  EXPECT_EQ(g.module.motions(), motions);
}

TEST(Pg70Driver, RestartOfTheModuleNeverResumesAMotion) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  const std::uint64_t ticket = move(g, 0.0, 0.01);
  g.run(0.3);
  const auto motions = g.module.motions();
  g.module.reboot(g.now);
  g.run(0.5);
  EXPECT_EQ(g.driver.reading().state, DriverState::kLost);
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kStanding; }, 5));
  EXPECT_TRUE(g.has_problem("the module has restarted"));
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kFailed);
  g.run(1);
  EXPECT_EQ(g.module.motions(), motions);
  EXPECT_EQ(run_to_end(g, move(g, 0.03)), Kind::kReached);
}

TEST(Pg70Driver, StuckFingerIsBlockedNotReached) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  g.plant.set_stuck(true);
  EXPECT_EQ(run_to_end(g, move(g, 0.02)), Kind::kBlocked);
  EXPECT_NEAR(g.driver.reading().opening, 0.069, 1e-4);
  g.plant.set_stuck(false);
  EXPECT_EQ(run_to_end(g, move(g, 0.02)), Kind::kReached);
}

TEST(Pg70Driver, MotionThatNobodyAskedForIsStopped) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  Move foreign{.command = Command::kMovePosition, .count = 2, .values = {0, 10}};
  g.module.receive(encode(foreign), g.now);  // another master on the bus
  ASSERT_TRUE(g.run_until([&] { return !g.module.is_moving(); }, 2));
  EXPECT_GT(g.module.motion().opening, 0.05);
  EXPECT_TRUE(g.has_problem("moves although it was not told to"));
}

TEST(Pg70Driver, UnitsOfTheModule) {
  for (const UnitSystem unit : {UnitSystem::kMetre, UnitSystem::kInch, UnitSystem::kMillimetre}) {
    ModuleOptions options;
    options.unit = unit;
    VirtualGripper g({}, options);
    ASSERT_TRUE(g.connect());
    EXPECT_NEAR(g.driver.reading().opening, 0.069, 1e-6);
    EXPECT_EQ(run_to_end(g, move(g, 0.025)), Kind::kReached);
    EXPECT_NEAR(g.module.motion().opening, 0.025, 1e-4);
  }
  ModuleOptions radians;
  radians.unit = UnitSystem::kRadian;
  VirtualGripper g({}, radians);
  EXPECT_FALSE(g.connect());
  EXPECT_EQ(g.driver.reading().state, DriverState::kConnecting);
  EXPECT_TRUE(g.has_problem("unit system 3"));
}

}  // namespace
}  // namespace prehend::drivers::pg70
