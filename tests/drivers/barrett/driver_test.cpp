#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "drivers/barrett/driver/health.h"
#include "tests/drivers/barrett/virtual_hand.h"

namespace prehend::drivers::barrett {
namespace {

using ::testing::HasSubstr;
using Kind = MotionReport::Kind;

constexpr int kGo = static_cast<int>(Command::kMove);
const AxisValues kOpen{0.3, 0.3, 0.3, 0.5};
const AxisValues kClosed{1.6, 1.6, 1.6, 0.5};

TEST(BarrettDriver, StopIsTheFirstThingThatIsSaid) {
  VirtualHand g;
  g.driver.connected(g.now);
  ASSERT_GE(g.sent.size(), kAxes);
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_EQ(g.sent[i], encode(Request{i, static_cast<std::uint8_t>(Property::kMode), 0}));
  }
  ASSERT_TRUE(g.connect());
  EXPECT_EQ(g.driver.reading().firmware, "174");
  g.run(10);
  EXPECT_EQ(g.driver.reading().state, DriverState::kUninitialised);
  for (const auto& celsius : g.driver.reading().motor_temperature) EXPECT_EQ(celsius, 25);
  EXPECT_EQ(g.hand.moves(), 0u);
  EXPECT_EQ(g.hand.property(0, Property::kStallTime), 250);
  EXPECT_EQ(g.hand.property(0, Property::kHold), 0);
  EXPECT_EQ(g.hand.property(kSpread, Property::kHold), 1);
  EXPECT_EQ(g.driver.counters().strange, 0u);
}

TEST(BarrettDriver, MovesNothingBeforeItIsInitialised) {
  VirtualHand g;
  for (std::size_t i = 0; i < kAxes; ++i) g.plant.place(i, 0.8);
  ASSERT_TRUE(g.connect());
  std::uint64_t ticket = 0;
  EXPECT_THAT(g.driver.move_to(g.goal(kOpen), g.now, ticket), HasSubstr("/hand/initialise"));
  ASSERT_EQ(g.driver.initialise(g.now, ticket), "");
  EXPECT_EQ(g.driver.reading().state, DriverState::kInitialising);
  g.run(0.3);
  EXPECT_EQ(g.hand.mode(0), Mode::kVelocity);
  EXPECT_EQ(g.hand.mode(kSpread), Mode::kIdle) << "fingers first";
  EXPECT_THAT(g.driver.move_to(g.goal(kOpen), g.now, ticket), HasSubstr("being initialised"));
  EXPECT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kStanding; }, 20));
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_NEAR(g.hand.motion().position[i], 0, 0.01);
    EXPECT_NEAR(g.driver.reading().position[i], 0, 0.01);
    EXPECT_LE(g.fastest[i], bh8_limits().max_speed[i] * 1.001);
  }
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kReached);
  EXPECT_EQ(g.move(g.goal(kOpen)).kind, Kind::kReached);
}

TEST(BarrettDriver, InitialisesByItselfOnceWhereToldTo) {
  DriverOptions options;
  options.initialisation = Initialisation::kAtStart;
  HandOptions of_hand;
  VirtualHand g(options, of_hand);
  g.driver.connected(g.now);
  EXPECT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kStanding; }, 20));
  EXPECT_EQ(g.hand.moves(), kAxes);
  // After the hand was switched off and on it has to be asked for.
  g.hand.reboot(g.now);
  g.run(5);
  EXPECT_EQ(g.driver.reading().state, DriverState::kUninitialised);
  EXPECT_EQ(g.hand.moves(), kAxes);
}

// An emergency stop may be there before the hand is.
TEST(BarrettDriver, WhatIsStoppedDoesNotInitialiseByItself) {
  DriverOptions options;
  options.initialisation = Initialisation::kAtStart;
  VirtualHand g(options);
  g.driver.stop(g.now, "emergency stop");
  ASSERT_TRUE(g.connect());
  g.run(5);
  EXPECT_EQ(g.driver.reading().state, DriverState::kUninitialised);
  EXPECT_EQ(g.hand.moves(), 0u);
  std::uint64_t ticket = 0;
  EXPECT_EQ(g.driver.initialise(g.now, ticket), "");
}

TEST(BarrettDriver, ZeroOfAHandThatWasInitialisedIsBelieved) {
  DriverOptions options;
  options.initialisation = Initialisation::kDone;
  HandOptions of_hand;
  of_hand.is_awake = true;
  VirtualHand g(options, of_hand);
  ASSERT_TRUE(g.connect());
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
  // But not of one that has just got its supply.
  VirtualHand asleep(options);
  ASSERT_TRUE(asleep.connect());
  EXPECT_EQ(asleep.driver.reading().state, DriverState::kUninitialised);
}

TEST(BarrettDriver, GoesThereWithTheSpeedAndTorqueThatWereAskedFor) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  g.fastest.fill(0);
  g.strongest.fill(0);
  const std::uint64_t unanswered = g.driver.counters().unanswered;  // while it woke
  const MotionReport report = g.move(g.goal(kOpen, 0.3, 400));
  EXPECT_EQ(report.kind, Kind::kReached) << report.reason;
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_NEAR(g.driver.reading().position[i], kOpen[i], 0.02);
    EXPECT_NEAR(g.hand.motion().position[i], kOpen[i], 0.02);
    EXPECT_LE(g.fastest[i], 0.3 * 1.001) << i;
    EXPECT_GT(g.fastest[i], 0.25) << i;
    EXPECT_EQ(g.hand.property(i, Property::kMostTorque), 400);
    EXPECT_EQ(g.hand.mode(i), i == kSpread ? Mode::kPosition : Mode::kIdle);
  }
  EXPECT_EQ(g.driver.counters().unanswered, unanswered);
}

TEST(BarrettDriver, BlockedFingerStaysAndPressesWhileOthersGoOn) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  ASSERT_EQ(g.move(g.goal(kOpen)).kind, Kind::kReached);
  g.plant.put_object(1, 0.9);
  g.strongest.fill(0);
  const MotionReport report = g.move(g.goal(kClosed, 1, 700));
  EXPECT_EQ(report.kind, Kind::kBlocked) << report.reason;
  const Reading& reading = g.driver.reading();
  EXPECT_EQ(reading.state, DriverState::kHolding);
  EXPECT_TRUE(reading.blocked[1]);
  EXPECT_FALSE(reading.blocked[0]);
  EXPECT_NEAR(reading.position[1], 0.9, 0.01);
  EXPECT_NEAR(reading.position[0], kClosed[0], 0.02);
  EXPECT_NEAR(g.strongest[1], 700, 1) << "it presses with what was asked for";
  EXPECT_EQ(g.hand.mode(1), Mode::kIdle) << "its worm gear holds";
  g.run(3);
  EXPECT_EQ(reading.state, DriverState::kHolding);
  EXPECT_GT(reading.effort[1], 0.1) << "the gauge feels it";
  EXPECT_NEAR(reading.effort[0], 0, 0.05);
  // Lets go again.
  g.plant.remove_objects();
  EXPECT_EQ(g.move(g.goal(kOpen)).kind, Kind::kReached);
}

TEST(BarrettDriver, OpenClutchIsToldOfBothLinks) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  ASSERT_EQ(g.move(g.goal(kOpen)).kind, Kind::kReached);
  g.plant.hold_joint(0, 0.8, 1.2);
  const MotionReport report = g.move(g.goal(kClosed));
  EXPECT_EQ(report.kind, Kind::kBlocked) << report.reason;
  const Reading& reading = g.driver.reading();
  EXPECT_TRUE(reading.has_joint_encoders);
  EXPECT_TRUE(reading.clutch_open[0]);
  EXPECT_FALSE(reading.clutch_open[1]);
  EXPECT_NEAR(reading.joint[0], 0.8, 0.01);
  EXPECT_NEAR(reading.position[0], 1.2, 0.01);
  EXPECT_NEAR(reading.joint[1], reading.position[1], 1e-3);
  // The motor gets to its target, and the inner link is held: it presses.
  g.plant.remove_objects();
  ASSERT_EQ(g.move(g.goal(kOpen)).kind, Kind::kReached);
  g.plant.hold_joint(0, 0.8, 2);
  EXPECT_EQ(g.move(g.goal(kClosed)).kind, Kind::kBlocked);
  EXPECT_NEAR(g.driver.reading().position[0], kClosed[0], 0.02);
}

TEST(BarrettDriver, HandWithoutEncodersBehindItsClutchesMoves) {
  HandOptions of_hand;
  of_hand.has_joint_encoders = false;
  VirtualHand g({}, of_hand);
  ASSERT_TRUE(g.begin());
  EXPECT_EQ(g.move(g.goal(kOpen)).kind, Kind::kReached);
  EXPECT_FALSE(g.driver.reading().has_joint_encoders);
  EXPECT_EQ(g.driver.reading().joint[0], g.driver.reading().position[0]);
}

TEST(BarrettDriver, StopHaltsAndALateMoveMovesNothing) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  std::uint64_t ticket = 0;
  ASSERT_EQ(g.driver.move_to(g.goal(kClosed), g.now, ticket), "");
  ASSERT_TRUE(g.run_until([&] { return g.hand.is_moving(); }));
  g.run(0.2);
  g.driver.stop(g.now, "enough");
  EXPECT_TRUE(g.run_until([&] { return !g.hand.is_moving(); }, 0.05));
  EXPECT_TRUE(g.run_until([&] { return g.driver.is_settled(); }, 1));
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kFailed);
  EXPECT_EQ(g.driver.report(ticket).reason, "enough");
  const AxisValues stood = g.hand.motion().position;
  g.hand.receive(encode(Request{0, static_cast<std::uint8_t>(Property::kCommand), kGo}), g.now);
  g.run(1);
  for (std::size_t i = 0; i < kAxes; ++i) EXPECT_NEAR(g.hand.motion().position[i], stood[i], 0.01);
}

TEST(BarrettDriver, RefusesWhatMakesNoSenseInWords) {
  VirtualHand g;
  std::uint64_t ticket = 0;
  EXPECT_THAT(g.driver.move_to(g.goal(kOpen), g.now, ticket), HasSubstr("not connected"));
  EXPECT_THAT(g.driver.initialise(g.now, ticket), HasSubstr("not connected"));
  ASSERT_TRUE(g.begin());
  const std::uint64_t moves = g.hand.moves();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](const HandGoal& goal) { return g.driver.move_to(goal, g.now, ticket); };
  HandGoal goal = g.goal(kOpen);
  goal.position[0] = -0.1;
  EXPECT_THAT(refused(goal), HasSubstr("F1 at -0.1 rad is outside 0 to 2.443"));
  goal.position[0] = nan;
  EXPECT_THAT(refused(goal), HasSubstr("not finite"));
  EXPECT_THAT(refused(g.goal(kOpen, 0)), HasSubstr("speed"));
  EXPECT_THAT(refused(g.goal(kOpen, 1, -1)), HasSubstr("torque limit"));
  EXPECT_THAT(g.driver.command(CommandMode::kVelocity, goal.moves, {nan}, g.now),
              HasSubstr("not finite"));
  g.run(1);
  EXPECT_EQ(g.hand.moves(), moves);
  DriverOptions bad;
  bad.reply_time = nan;
  EXPECT_THROW(VirtualHand{bad}, std::invalid_argument);
  bad = {};
  bad.limits.max_current[2] = 40000;
  EXPECT_THROW(VirtualHand{bad}, std::invalid_argument);
  bad = {};
  bad.limits.upper[0] = 40;
  EXPECT_THROW(VirtualHand{bad}, std::invalid_argument);
}

TEST(BarrettDriver, SpeedsAndTorquesAreCutToTheLimits) {
  DriverOptions options;
  options.limits.max_speed.fill(0.5);
  options.limits.max_current.fill(900);
  VirtualHand g(options);
  ASSERT_TRUE(g.begin());
  EXPECT_EQ(g.move(g.goal(kOpen, 5, 3000)).kind, Kind::kReached);
  g.plant.put_object(0, 0.6);
  EXPECT_EQ(g.move(g.goal(kClosed, 5, 0)).kind, Kind::kBlocked);
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_LE(g.fastest[i], 0.5 * 1.001) << i;
    EXPECT_LE(g.strongest[i], 900) << i;
  }
}

TEST(BarrettDriver, SpeedCommandsAreDrawnOutAndTheWatchdogStopsThem) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  ASSERT_EQ(g.move(g.goal(kOpen)).kind, Kind::kReached);
  g.fastest.fill(0);
  std::array<bool, kAxes> moves{};
  AxisValues speeds{};
  moves[0] = moves[1] = true;
  speeds[0] = 0.2;
  speeds[1] = -0.05;
  for (int i = 0; i < 300; ++i) {
    ASSERT_EQ(g.driver.command(CommandMode::kVelocity, moves, speeds, g.now), "");
    g.run(0.01);
  }
  EXPECT_NEAR(g.hand.motion().position[0], 0.3 + 0.6, 0.1) << "3 s at 0.2 rad/s";
  EXPECT_NEAR(g.hand.motion().position[1], 0.3 - 0.15, 0.05);
  EXPECT_NEAR(g.hand.motion().position[2], 0.3, 0.02);
  EXPECT_LE(g.fastest[0], 0.2 * 1.001);
  const double there = g.hand.motion().position[0];
  g.run(1);
  EXPECT_TRUE(g.has_problem("no hand command for 0.2 s"));
  EXPECT_FALSE(g.hand.is_moving());
  EXPECT_LT(g.hand.motion().position[0], there + 0.2 * 0.3);
}

TEST(BarrettDriver, SpeedEndsByItselfWhenBusAndDriverDie) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  std::array<bool, kAxes> moves{};
  moves[0] = true;
  AxisValues speeds{};
  speeds[0] = 0.2;
  for (int i = 0; i < 100; ++i) {
    g.driver.command(CommandMode::kVelocity, moves, speeds, g.now);
    g.run(0.01);
  }
  g.is_cut = true;
  const double there = g.hand.motion().position[0];
  g.run(3);
  EXPECT_FALSE(g.hand.is_moving());
  EXPECT_LT(g.hand.motion().position[0], there + 0.2 * 0.6) << "a stretch of 0.5 s at most";
  EXPECT_EQ(g.driver.reading().state, DriverState::kLost);
}

TEST(BarrettDriver, PositionCommandIsSentOnceHoweverOftenItComes) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  const std::uint64_t before = g.hand.moves();
  std::array<bool, kAxes> moves{};
  moves[2] = true;
  AxisValues position{};
  position[2] = 0.3;
  for (int i = 0; i < 300; ++i) {
    ASSERT_EQ(g.driver.command(CommandMode::kPosition, moves, position, g.now), "");
    g.run(0.01);
  }
  EXPECT_NEAR(g.hand.motion().position[2], 0.3, 0.02);
  EXPECT_EQ(g.hand.moves(), before + 1);
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
}

TEST(BarrettDriver, WhoIsNotNamedGoesOn) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  std::uint64_t first = 0, second = 0;
  ASSERT_EQ(g.driver.move_to(g.goal(kClosed, 0.5), g.now, first), "");
  g.run(0.5);
  HandGoal goal;
  goal.moves[0] = true;
  goal.position[0] = 0.1;
  goal.speed[0] = 1;
  ASSERT_EQ(g.driver.move_to(goal, g.now, second), "");
  EXPECT_EQ(g.driver.report(first).kind, Kind::kReplaced);
  EXPECT_TRUE(g.run_until([&] { return g.driver.report(second).kind == Kind::kReached; }));
  EXPECT_NEAR(g.hand.motion().position[0], 0.1, 0.02);
  EXPECT_NEAR(g.hand.motion().position[1], kClosed[1], 0.02);
}

TEST(BarrettDriver, StopThatIsNotAnsweredSwitchesOff) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  std::uint64_t ticket = 0;
  g.driver.move_to(g.goal(kClosed, 0.1), g.now, ticket);
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().moving && g.hand.is_moving(); }));
  g.run(0.2);
  g.hand.set_deaf_to(Property::kMode);
  g.driver.stop(g.now);
  EXPECT_TRUE(g.run_until([&] { return !g.hand.is_moving(); }, 2));
  EXPECT_TRUE(g.has_problem("its motor is told to switch off, too"));
}

TEST(BarrettDriver, LostAnswersEndTheMotionAndNothingResumes) {
  for (const bool one_puck : {false, true}) {
    VirtualHand g;
    ASSERT_TRUE(g.begin());
    std::uint64_t ticket = 0;
    g.driver.move_to(g.goal(kClosed, 0.05), g.now, ticket);
    ASSERT_TRUE(g.run_until([&] { return g.hand.is_moving(); }));
    g.run(0.2);
    const auto axis = one_puck ? std::optional<std::size_t>(2) : std::nullopt;
    g.hand.set_mute(true, axis);
    g.run(1.5);
    EXPECT_EQ(g.driver.reading().state, DriverState::kLost);
    EXPECT_FALSE(g.hand.is_moving()) << "it hears MODE 0, though nothing is heard of it";
    EXPECT_EQ(g.driver.report(ticket).kind, Kind::kFailed);
    EXPECT_THAT(g.driver.move_to(g.goal(kOpen), g.now, ticket), HasSubstr("answers are missing"));
    const std::uint64_t moves = g.hand.moves();
    g.hand.set_mute(false, axis);
    EXPECT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kStanding; }, 5));
    g.run(2);
    EXPECT_EQ(g.hand.moves(), moves);
  }
}

TEST(BarrettDriver, SwitchedOffAndOnItIsNoLongerInitialised) {
  for (const bool starts_itself : {false, true}) {
    HandOptions of_hand;
    of_hand.self_start = starts_itself ? 0.05 : 0;  // so soon that no answer is missed for long
    VirtualHand g({}, of_hand);
    ASSERT_TRUE(g.begin());
    g.run(10);
    std::uint64_t ticket = 0;
    ASSERT_EQ(g.driver.move_to(g.goal(kClosed, 0.1), g.now, ticket), "");
    g.run(1);
    const std::uint64_t moves = g.hand.moves();
    g.hand.reboot(g.now);
    g.run(4);
    EXPECT_EQ(g.driver.reading().state, DriverState::kUninitialised) << starts_itself;
    EXPECT_EQ(g.driver.report(ticket).kind, Kind::kFailed);
    EXPECT_EQ(g.hand.moves(), moves);
  }
}

TEST(BarrettDriver, MotionThatNobodyAskedForIsStopped) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  const std::uint64_t moves = g.hand.moves();
  g.hand.receive(encode(Request{1, static_cast<std::uint8_t>(Property::kMostVelocity), 20}), g.now);
  g.hand.receive(encode(Request{1, static_cast<std::uint8_t>(Property::kMove), 150000}), g.now);
  g.run(2);
  EXPECT_EQ(g.hand.moves(), moves + 1);
  EXPECT_TRUE(g.has_problem("the hand moves although it was not told to"));
  EXPECT_FALSE(g.hand.is_moving());
  EXPECT_LT(g.hand.motion().position[1], 0.3);
}

TEST(BarrettDriver, WhatIsNotInForceIsNotMovedWith) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  const std::uint64_t moves = g.hand.moves();
  g.hand.set_deaf_to(Property::kMostTorque);
  const MotionReport report = g.move(g.goal(kOpen, 1, 500));
  EXPECT_EQ(report.kind, Kind::kFailed);
  EXPECT_THAT(report.reason, HasSubstr("the hand does not take MT of"));
  EXPECT_EQ(g.hand.moves(), moves);
  ASSERT_TRUE(g.run_until([&] { return g.driver.is_settled(); }));
  g.hand.set_deaf_to(Property::kCommand);
  const MotionReport silent = g.move(g.goal(kOpen, 1, 500));
  EXPECT_EQ(silent.kind, Kind::kFailed);
  EXPECT_THAT(silent.reason, HasSubstr("does not begin its motion"));
}

TEST(BarrettDriver, PuckInErrorStopsTheHand) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  std::uint64_t ticket = 0;
  g.driver.move_to(g.goal(kClosed, 0.1), g.now, ticket);
  g.run(0.5);
  g.hand.set_error(true);
  g.run(1);
  EXPECT_EQ(g.driver.reading().state, DriverState::kFault);
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kFailed);
  EXPECT_THAT(g.driver.move_to(g.goal(kOpen), g.now, ticket), HasSubstr("in error"));
}

// MT falls to nothing at OTEMP: a hand that is too hot stalls in the air.
TEST(BarrettDriver, HeatIsToldAndAHotHandStalls) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  g.hand.set_temperature(75);
  EXPECT_EQ(g.move(g.goal(kOpen)).kind, Kind::kBlocked);
  g.run(6);
  Situation situation;
  situation.reading = g.driver.reading();
  const Health health = health_of(situation);
  EXPECT_EQ(health.level, Health::Level::kWarning);
  EXPECT_THAT(health.words, ::testing::ContainsRegex("F1 is 7[0-5] degree Celsius hot"));
}

TEST(BarrettDriver, PadsAreReadWhole) {
  VirtualHand g;
  Cells cells{};
  for (std::size_t i = 0; i < kCells; ++i) cells[i] = static_cast<std::uint16_t>(7 * i);
  g.hand.set_cells(1, cells);
  ASSERT_TRUE(g.connect());
  g.images.clear();
  g.run(1);
  EXPECT_NEAR(static_cast<double>(g.images.size()), 4 * 25, 8);
  for (const auto& [axis, image] : g.images) EXPECT_EQ(image, axis == 1 ? cells : Cells{});
  EXPECT_EQ(g.driver.broken_images(), 0u);
  g.from_hand.set_faults({.dropped = 0.02});
  g.images.clear();
  g.run(2);
  EXPECT_GT(g.images.size(), 100u);
  EXPECT_GT(g.driver.broken_images(), 0u);
  for (const auto& [axis, image] : g.images) EXPECT_EQ(image, axis == 1 ? cells : Cells{});
}

TEST(BarrettDriver, PadThatIsNotInitialisedIsTold) {
  VirtualHand g;
  g.hand.set_pad_failure(true);
  ASSERT_TRUE(g.begin());
  g.run(1);
  EXPECT_TRUE(g.images.empty());
  Situation situation;
  situation.reading = g.driver.reading();
  EXPECT_THAT(health_of(situation).words, HasSubstr("the pad of F1 is not initialised"));
}

// Answers that came later than all tries of their question were taken for none, for ever.
TEST(BarrettDriver, AnswersMayBeLateForLong) {
  DriverOptions options;
  options.loss_time = 2;
  options.begin_time = 2;
  VirtualHand g(options);
  ASSERT_TRUE(g.begin());
  g.from_hand.set_faults({.late = 1, .delay = std::chrono::milliseconds(200)});
  g.run(5);
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
  EXPECT_EQ(g.driver.counters().connections, 1u);
  EXPECT_EQ(g.move(g.goal(kOpen, 0.3)).kind, Kind::kReached);
  g.from_hand.set_faults({});
  g.run(1);
  EXPECT_EQ(g.move(g.goal(kClosed)).kind, Kind::kReached);
}

TEST(BarrettDriver, PuckThatIsMissingIsNamed) {
  VirtualHand g;
  g.hand.set_mute(true, 2);
  g.driver.connected(g.now);
  g.run(2);
  EXPECT_EQ(g.driver.reading().state, DriverState::kConnecting);
  const std::array<bool, kAxes> answers{true, true, false, true};
  EXPECT_EQ(g.driver.reading().answers, answers);
  EXPECT_EQ(g.hand.moves(), 0u);
}

TEST(BarrettDriver, AnswersThatCannotBeAreStrange) {
  VirtualHand g;
  ASSERT_TRUE(g.begin());
  const std::uint64_t before = g.driver.counters().strange;
  g.driver.receive(encode(Value{0, static_cast<std::uint8_t>(Property::kVersion), 3}), g.now);
  CanFrame other;
  other.identifier = 0x7FF;
  g.driver.receive(other, g.now);
  EXPECT_EQ(g.driver.counters().strange, before + 2);
  g.run(1);
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
}

TEST(BarrettHealth, NamesTheMend) {
  Situation s;
  s.line = "can0";
  s.reading.state = DriverState::kConnecting;
  EXPECT_EQ(health_of(s).level, Health::Level::kOk);
  s.connecting = 3;
  EXPECT_THAT(health_of(s).words, HasSubstr("does not answer on can0. Check its supply (48 V)"));
  s.reading.answers = {true, false, true, false};
  EXPECT_THAT(health_of(s).words, HasSubstr("these do not answer: F2, spread on can0"));
  s.reading.state = DriverState::kDisconnected;
  s.line_problem = "cannot open it";
  EXPECT_EQ(health_of(s).level, Health::Level::kError);
  s.reading.state = DriverState::kFault;
  EXPECT_THAT(health_of(s).words, HasSubstr("Switch its supply off and on"));
  s.reading.state = DriverState::kUninitialised;
  EXPECT_EQ(health_of(s).level, Health::Level::kWarning);
  EXPECT_THAT(health_of(s).words, HasSubstr("/hand/initialise"));
  s.reading.state = DriverState::kStanding;
  EXPECT_EQ(health_of(s), (Health{Health::Level::kOk, "standing"}));
  s.link_problem = "bad";
  EXPECT_EQ(health_of(s).words, "standing; bad");
}

}  // namespace
}  // namespace prehend::drivers::barrett
