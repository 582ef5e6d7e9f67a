#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "drivers/sdh/driver/health.h"
#include "tests/drivers/sdh/virtual_hand.h"

namespace prehend::drivers::sdh {
namespace {

using ::testing::HasSubstr;
using Kind = MotionReport::Kind;

const AxisValues kOpen{0.5, -0.45, 0.45, -0.45, 0.45, -0.45, 0.45};
const AxisValues kClosed{0.5, 0.45, -0.45, 0.45, -0.45, 0.45, -0.45};

bool says(const std::vector<std::uint8_t>& block, const std::string& text) {
  return std::string(block.begin(), block.end()).find(text) != std::string::npos;
}

TEST(SdhDriver, StopIsTheFirstThingThatIsSaid) {
  VirtualHand g;
  g.driver.connected(g.now);
  ASSERT_GE(g.sent.size(), 2u);
  EXPECT_TRUE(says(g.sent[0], " \r\n"));
  EXPECT_TRUE(says(g.sent[1], "stop"));
  ASSERT_TRUE(g.connect());
  EXPECT_EQ(g.driver.reading().firmware, "0.0.3.3");
  EXPECT_EQ(g.driver.reading().state, DriverState::kOff);
  EXPECT_EQ(g.hand.moves(), 0u);
  g.run(10);
  EXPECT_EQ(g.driver.reading().temperatures.size(), 9u);
  EXPECT_EQ(g.hand.moves(), 0u);
}

class SdhForms : public ::testing::TestWithParam<bool> {
 protected:
  DriverOptions options() const {
    DriverOptions all;
    all.binary = GetParam();
    return all;
  }
};
INSTANTIATE_TEST_SUITE_P(Forms, SdhForms, ::testing::Values(true, false),
                         [](const auto& form) { return form.param ? "binary" : "text"; });

TEST_P(SdhForms, GoesThereWithTheSpeedAndCurrentThatWereAskedFor) {
  VirtualHand g(options());
  ASSERT_TRUE(g.connect());
  const MotionReport report = g.move(g.goal(kOpen, 0.3, 0.25));
  EXPECT_EQ(report.kind, Kind::kReached) << report.reason;
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_NEAR(g.driver.reading().position[i], kOpen[i], 0.01);
    EXPECT_NEAR(g.hand.motion().position[i], kOpen[i], 0.01);
    EXPECT_LE(g.fastest[i], 0.3 * 1.001);
    EXPECT_NEAR(g.hand.current_limits()[i], 0.25, 0.01);
  }
  EXPECT_EQ(g.driver.counters().unanswered, 0u);
}

TEST_P(SdhForms, BlockedFingerStaysAndPressesWhileOthersGoOn) {
  VirtualHand g(options());
  ASSERT_TRUE(g.connect());
  ASSERT_EQ(g.move(g.goal(kOpen)).kind, Kind::kReached);
  g.plant.put_object(1, 0.1);
  const MotionReport report = g.move(g.goal(kClosed, 0.3, 0.2));
  EXPECT_EQ(report.kind, Kind::kBlocked) << report.reason;
  const Reading& reading = g.driver.reading();
  EXPECT_EQ(reading.state, DriverState::kHolding);
  EXPECT_TRUE(reading.blocked[1]);
  EXPECT_FALSE(reading.blocked[2]);
  // The distal joint is where the finger's straight line has it at the blocked proximal one.
  EXPECT_NEAR(reading.position[1], 0.1, 0.01);
  EXPECT_NEAR(reading.position[2], -0.1, 0.02);
  EXPECT_NEAR(reading.position[3], kClosed[3], 0.01);
  g.run(2);
  EXPECT_EQ(g.driver.reading().state, DriverState::kHolding);
  EXPECT_NEAR(g.hand.motion().current[1], 0.2, 0.01) << "it presses with what was asked for";
  // Pressed harder, the same way.
  EXPECT_EQ(g.move(g.goal(kClosed, 0.3, 0.4)).kind, Kind::kBlocked);
  EXPECT_NEAR(g.hand.motion().current[1], 0.4, 0.01);
  // What it held is taken away.
  g.plant.remove_object();
  EXPECT_TRUE(g.run_until([&] { return !g.driver.reading().is_blocked(); }, 3));
  EXPECT_TRUE(g.has_problem("the grip is lost: axis 1"));
}

// The hand goes on to say "positioning" of an axis that presses a little short of its target: such
// a motion never ended.
TEST_P(SdhForms, AxisThatStandsALittleShortOfItsTargetHasArrived) {
  VirtualHand g(options());
  ASSERT_TRUE(g.connect());
  AxisValues there{};
  there.fill(0.3);
  g.plant.put_object(1, 0.3 - 0.4 * kDegree);
  const std::uint64_t stops = g.hand.stops();  // of the connection
  const MotionReport report = g.move(g.goal(there, 0.5));
  EXPECT_EQ(report.kind, Kind::kReached) << report.reason;
  ASSERT_EQ(g.hand.state(1), AxisState::kPositioning);
  g.run(3);
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
  EXPECT_FALSE(g.has_problem("although it was not told to"));
  EXPECT_EQ(g.hand.stops(), stops);
  EXPECT_EQ(g.move(g.goal(kOpen, 0.5)).kind, Kind::kReached);
}

TEST_P(SdhForms, StopHaltsAndALateMoveMovesNothing) {
  VirtualHand g(options());
  ASSERT_TRUE(g.connect());
  std::uint64_t ticket = 0;
  ASSERT_EQ(g.driver.move_to(g.goal(kOpen), g.now, ticket), "");
  ASSERT_TRUE(g.run_until([&] { return g.hand.is_moving(); }));
  g.run(0.2);
  g.driver.stop(g.now, "enough");
  EXPECT_TRUE(g.run_until([&] { return g.driver.is_settled(); }, 2));
  EXPECT_FALSE(g.hand.is_moving());
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kFailed);
  EXPECT_EQ(g.driver.report(ticket).reason, "enough");
  const AxisValues stood = g.hand.motion().position;
  const std::string late = "m\r\n";
  g.hand.receive({reinterpret_cast<const std::uint8_t*>(late.data()), late.size()}, g.now);
  g.run(1);
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_NEAR(g.hand.motion().position[i], stood[i], 0.005);
  }
}

TEST(SdhDriver, RefusesWhatMakesNoSenseInWords) {
  VirtualHand g;
  std::uint64_t ticket = 0;
  EXPECT_THAT(g.driver.move_to(g.goal(kOpen), g.now, ticket), HasSubstr("not connected"));
  ASSERT_TRUE(g.connect());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](const HandGoal& goal) { return g.driver.move_to(goal, g.now, ticket); };
  HandGoal goal = g.goal(kOpen);
  goal.position[0] = -0.1;
  EXPECT_THAT(refused(goal), HasSubstr("axis 0 at -0.1 rad is outside 0 to 1.571"));
  goal.position[0] = nan;
  EXPECT_THAT(refused(goal), HasSubstr("not finite"));
  goal = g.goal(kOpen, 0);
  EXPECT_THAT(refused(goal), HasSubstr("speed"));
  goal = g.goal(kOpen, 0.1, -1);
  EXPECT_THAT(refused(goal), HasSubstr("current limit"));
  EXPECT_THAT(g.driver.command(CommandMode::kVelocity, goal.moves, {nan}, g.now),
              HasSubstr("not finite"));
  g.run(1);
  EXPECT_EQ(g.hand.moves(), 0u);
  DriverOptions bad;
  bad.reply_time = nan;
  EXPECT_THROW(VirtualHand{bad}, std::invalid_argument);
  bad = {};
  bad.limits.max_speed[2] = 0;
  EXPECT_THROW(VirtualHand{bad}, std::invalid_argument);
}

TEST(SdhDriver, SpeedsAreCutToTheHandsOwnLimits) {
  HandOptions of_hand;
  of_hand.speed_limit.fill(20);  // deg/s
  VirtualHand g({}, of_hand);
  ASSERT_TRUE(g.connect());
  EXPECT_EQ(g.move(g.goal(kOpen, 1.4)).kind, Kind::kReached);
  for (std::size_t i = 0; i < kAxes; ++i) EXPECT_LE(g.fastest[i], 20 * kDegree * 1.001);
}

TEST(SdhDriver, SpeedCommandsAreDrawnOutAndTheWatchdogStopsThem) {
  VirtualHand g;
  ASSERT_TRUE(g.connect());
  std::array<bool, kAxes> moves{};
  AxisValues speeds{};
  moves[1] = moves[3] = true;
  speeds[1] = 0.2;
  speeds[3] = -0.1;
  for (int i = 0; i < 300; ++i) {
    ASSERT_EQ(g.driver.command(CommandMode::kVelocity, moves, speeds, g.now), "");
    g.run(0.01);
  }
  EXPECT_NEAR(g.hand.motion().position[1], 0.6, 0.1) << "3 s at 0.2 rad/s, less the beginning";
  EXPECT_NEAR(g.hand.motion().position[3], -0.3, 0.05);
  EXPECT_LE(g.fastest[1], 0.2 * 1.001);
  const double there = g.hand.motion().position[1];
  g.run(1);
  EXPECT_TRUE(g.has_problem("no hand command for 0.2 s"));
  EXPECT_FALSE(g.hand.is_moving());
  EXPECT_LT(g.hand.motion().position[1], there + 0.2 * 0.3);
}

TEST(SdhDriver, SpeedEndsByItselfWhenLineAndDriverDie) {
  VirtualHand g;
  ASSERT_TRUE(g.connect());
  std::array<bool, kAxes> moves{};
  moves[1] = true;
  AxisValues speeds{};
  speeds[1] = 0.2;
  for (int i = 0; i < 100; ++i) {
    g.driver.command(CommandMode::kVelocity, moves, speeds, g.now);
    g.run(0.01);
  }
  g.is_cut = true;
  const double there = g.hand.motion().position[1];
  g.run(3);
  EXPECT_FALSE(g.hand.is_moving());
  EXPECT_LT(g.hand.motion().position[1], there + 0.2 * 0.6) << "a stretch of 0.5 s at most";
  EXPECT_EQ(g.driver.reading().state, DriverState::kLost);
}

TEST(SdhDriver, PositionCommandIsSentOnceHoweverOftenItComes) {
  VirtualHand g;
  ASSERT_TRUE(g.connect());
  std::array<bool, kAxes> moves{};
  moves[2] = true;
  AxisValues position{};
  position[2] = 0.3;
  for (int i = 0; i < 300; ++i) {
    ASSERT_EQ(g.driver.command(CommandMode::kPosition, moves, position, g.now), "");
    g.run(0.01);
  }
  EXPECT_NEAR(g.hand.motion().position[2], 0.3, 0.01);
  EXPECT_EQ(g.hand.moves(), 1u);
  EXPECT_EQ(g.driver.reading().state, DriverState::kStanding);
}

TEST(SdhDriver, StopThatIsNotAnsweredSwitchesOff) {
  VirtualHand g;
  ASSERT_TRUE(g.connect());
  std::uint64_t ticket = 0;
  g.driver.move_to(g.goal(kOpen, 0.1), g.now, ticket);
  ASSERT_TRUE(g.run_until([&] { return g.driver.reading().moving && g.hand.is_moving(); }));
  g.run(0.2);
  g.hand.set_deaf_to(Command::kStop);
  g.driver.stop(g.now);
  EXPECT_TRUE(g.run_until([&] { return !g.hand.is_powered(1); }, 2));
  EXPECT_TRUE(g.has_problem("stop is not answered: the axes are switched off"));
}

TEST(SdhDriver, LostAnswersEndTheMotionAndNothingResumes) {
  VirtualHand g;
  ASSERT_TRUE(g.connect());
  std::uint64_t ticket = 0;
  g.driver.move_to(g.goal(kOpen, 0.05), g.now, ticket);
  ASSERT_TRUE(g.run_until([&] { return g.hand.is_moving(); }));
  g.hand.set_mute(true);
  g.run(2);
  EXPECT_EQ(g.driver.reading().state, DriverState::kLost);
  EXPECT_FALSE(g.hand.is_moving()) << "it hears stop, though nothing is heard of it";
  EXPECT_EQ(g.driver.report(ticket).kind, Kind::kFailed);
  EXPECT_THAT(g.driver.move_to(g.goal(kOpen), g.now, ticket), HasSubstr("answers are missing"));
  const std::uint64_t moves = g.hand.moves();
  g.hand.set_mute(false);
  EXPECT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kStanding; }, 5));
  g.run(2);
  EXPECT_EQ(g.hand.moves(), moves);
}

TEST(SdhDriver, MotionThatNobodyAskedForIsStopped) {
  VirtualHand g;
  ASSERT_TRUE(g.connect());
  for (const std::string line : {"p=0,80,0,0,0,0,0\r\n", "v=5,5,5,5,5,5,5\r\n", "m\r\n"}) {
    g.hand.receive({reinterpret_cast<const std::uint8_t*>(line.data()), line.size()}, g.now);
  }
  g.run(2);
  EXPECT_TRUE(g.has_problem("the hand moves although it was not told to"));
  EXPECT_FALSE(g.hand.is_moving());
  EXPECT_LT(g.hand.motion().position[1], 10 * kDegree);
}

TEST(SdhDriver, RefusalsOfTheHandAreTold) {
  VirtualHand g;
  ASSERT_TRUE(g.connect());
  g.hand.set_temperature(95);
  const MotionReport report = g.move(g.goal(kOpen));
  EXPECT_EQ(report.kind, Kind::kFailed);
  EXPECT_THAT(report.reason, HasSubstr("m was refused: E29 over-temperature"));
  EXPECT_EQ(g.driver.reading().error_code, 29);
  g.run(6);
  Situation situation;
  situation.reading = g.driver.reading();
  const Health health = health_of(situation);
  EXPECT_EQ(health.level, Health::Level::kWarning);
  EXPECT_THAT(health.words, ::testing::ContainsRegex("9[0-5] degree Celsius hot"));
  g.hand.set_temperature(30);
  EXPECT_EQ(g.move(g.goal(kOpen)).kind, Kind::kReached);
  EXPECT_EQ(g.driver.reading().error_code, 0);
  g.hand.set_refusal(28);
  EXPECT_THAT(g.move(g.goal(kClosed)).reason, HasSubstr("E28 axis disabled"));
}

// A speed that arrives ten times as great: the hand says what is in force.
TEST(SdhDriver, TextThatIsChangedOnItsWayIsNotActedOn) {
  DriverOptions options;
  options.binary = false;
  VirtualHand g(options);
  ASSERT_TRUE(g.connect());
  int changes = 0, most = 1;
  g.tamper = [&](VirtualHand::Block& block) {
    if (!says(block, "v=") || changes >= most) return;
    ++changes;
    const std::string worse = "v=57,57,57,57,57,57,57\r\n";
    block.assign(worse.begin(), worse.end());
  };
  EXPECT_EQ(g.move(g.goal(kOpen, 0.1)).kind, Kind::kReached);
  EXPECT_EQ(changes, 1);
  for (std::size_t i = 0; i < kAxes; ++i) EXPECT_LE(g.fastest[i], 0.1 * 1.01);
  const std::uint64_t moves = g.hand.moves();
  most = 100;
  const MotionReport report = g.move(g.goal(kClosed, 0.1));
  EXPECT_EQ(report.kind, Kind::kFailed);
  EXPECT_THAT(report.reason, HasSubstr("the hand does not take v"));
  EXPECT_EQ(g.hand.moves(), moves);
}

class SdhFirmwares : public ::testing::TestWithParam<Firmware> {};
TEST_P(SdhFirmwares, MovesWithEach) {
  HandOptions of_hand;
  of_hand.firmware = GetParam();
  of_hand.debug_lines = true;
  VirtualHand g({}, of_hand);
  ASSERT_TRUE(g.connect());
  EXPECT_EQ(g.move(g.goal(kOpen)).kind, Kind::kReached);
  EXPECT_EQ(g.has_problem("has no ramp"), !GetParam().has_smooth_ramp());
}
INSTANTIATE_TEST_SUITE_P(Versions, SdhFirmwares,
                         ::testing::Values(Firmware{{0, 0, 2, 0}}, Firmware{{0, 0, 2, 6}},
                                           Firmware{{0, 0, 2, 16}}, Firmware{{0, 0, 3, 3}}));

TEST(SdhDriver, AnswersThatCannotBeAreStrange) {
  VirtualHand g;
  ASSERT_TRUE(g.connect());
  const std::uint64_t before = g.driver.counters().strange;
  g.hear("E13\r\nPOS=nan,nan\r\nSTATE=9,9,9,9,9,9,9\r\nSTOP\r\nM=1\r\n");
  EXPECT_GE(g.driver.counters().strange, before + 5);
  g.run(1);
  EXPECT_EQ(g.driver.reading().state, DriverState::kOff);
  EXPECT_EQ(g.hand.moves(), 0u);
}

TEST(SdhHealth, NamesTheMend) {
  Situation s;
  s.line = "/dev/ttyUSB2";
  s.reading.state = DriverState::kConnecting;
  EXPECT_EQ(health_of(s).level, Health::Level::kOk);
  s.connecting = 3;
  EXPECT_THAT(health_of(s).words, HasSubstr("does not answer on /dev/ttyUSB2. Check its supply"));
  s.reading.state = DriverState::kDisconnected;
  s.line_problem = "cannot open it";
  EXPECT_EQ(health_of(s).level, Health::Level::kError);
  s.reading.state = DriverState::kFault;
  EXPECT_THAT(health_of(s).words, HasSubstr("Switch its supply off and on"));
  s.reading.state = DriverState::kStanding;
  EXPECT_EQ(health_of(s), (Health{Health::Level::kOk, "standing"}));
}

}  // namespace
}  // namespace prehend::drivers::sdh
