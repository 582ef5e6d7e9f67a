// The driver against the emulated controller, in made-up time.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "tests/drivers/kuka_rsi/virtual_robot.h"

namespace prehend::drivers::kuka_rsi {
namespace {

using namespace std::chrono_literals;
using End = Snapshot::End;

Axes beside_home(double way_of_a1) {
  Axes to = home_of_kuka();
  to[0] += way_of_a1;
  return to;
}

TEST(RsiDriver, AnswersEveryTelegramAndStandsStill) {
  VirtualRobot robot;
  robot.begin();
  robot.run(10);
  EXPECT_EQ(robot.snapshot().state, State::kHolding);
  EXPECT_EQ(robot.controller.delay(), 0u);
  EXPECT_EQ(robot.snapshot().answers, robot.snapshot().telegrams);
  EXPECT_LT(robot.fastest, 1e-6);
}

TEST(RsiDriver, FollowsATrajectoryAndArrives) {
  for (const double cycle : {0.012, 0.004}) {
    ControllerOptions controller = controller_of_kuka();
    controller.cycle = cycle;
    controller.ipoc_step = cycle == 0.004 ? 4 : 12;
    controller.answer_time = 0.8 * cycle;
    DriverOptions options;
    options.cycle = cycle;
    VirtualRobot robot(options, controller);
    robot.begin();
    ASSERT_TRUE(robot.move(beside_home(0.7), 1.0));
    robot.run(0.5);
    // Half of the way, but for the drives' lag.
    EXPECT_NEAR(robot.snapshot().actual[0], 0.35, 0.08);
    EXPECT_EQ(robot.snapshot().end, End::kRunning);
    robot.run(1.0);
    EXPECT_EQ(robot.snapshot().end, End::kReached);
    EXPECT_NEAR(robot.arm.actual()[0], 0.7, 2e-3);
    EXPECT_NEAR(robot.snapshot().time, 1.0, cycle);
    EXPECT_EQ(robot.controller.delay(), 0u);
    EXPECT_LT(robot.fastest, 1);
  }
}

// What the controller's own decimals do to corrections stays far below what axes can show.
TEST(RsiDriver, KeepsToTheRsiOfSimulatorsThatCountTelegrams) {
  ControllerOptions controller = controller_of_kuka();
  controller.ipoc_step = 1;
  controller.layout.has_lines = controller.layout.type_in_capitals = true;
  controller.short_first = true;
  VirtualRobot robot({}, controller);
  robot.begin();
  ASSERT_TRUE(robot.move(beside_home(0.3), 1.0));
  robot.run(2);
  EXPECT_EQ(robot.snapshot().end, End::kReached);
}

TEST(RsiDriver, StopBrakesWithinTheAcceleration) {
  VirtualRobot robot;
  robot.begin();
  ASSERT_TRUE(robot.move(beside_home(1.0), 1.0));
  robot.run(0.5);
  const double before = robot.snapshot().set_point[0];
  const double speed = 1.875;  // rad/s, the quintic's at its middle
  robot.driver->stop();
  robot.run(0.5);
  EXPECT_EQ(robot.snapshot().state, State::kHolding);
  EXPECT_EQ(robot.snapshot().end, End::kStopped);
  EXPECT_EQ(robot.snapshot().reason, Reason::kAsked);
  // v^2 / 2a, but for a cycle's way.
  EXPECT_NEAR(robot.snapshot().set_point[0] - before, speed * speed / 24, 0.04);
}

TEST(RsiDriver, LatchedStopTakesNothingUntilItIsReleased) {
  VirtualRobot robot;
  robot.begin();
  ASSERT_TRUE(robot.move(beside_home(1.0), 1.0));
  robot.run(0.3);
  robot.driver->latch();
  robot.run(0.5);
  EXPECT_EQ(robot.snapshot().reason, Reason::kLatched);
  EXPECT_FALSE(robot.move(beside_home(1.0), 2.0));
  robot.run(1);
  EXPECT_TRUE(robot.snapshot().latched);
  EXPECT_EQ(robot.controller.delay(), 0u);  // answered all the while
  robot.driver->release();
  EXPECT_TRUE(robot.move(beside_home(1.0), 2.0));
  robot.run(3);
  EXPECT_EQ(robot.snapshot().end, End::kReached);
}

TEST(RsiDriver, ContactStopsItWithTheNextAnswer) {
  VirtualRobot robot;
  robot.begin();
  robot.driver->feel(1, robot.now);
  ASSERT_TRUE(robot.move(beside_home(1.0), 2.0, 10));
  for (int i = 0; i < 50; ++i) {
    robot.driver->feel(9.9, robot.now);
    robot.step();
  }
  EXPECT_EQ(robot.snapshot().state, State::kMoving);
  robot.driver->feel(10.1, robot.now);
  robot.step();
  EXPECT_EQ(robot.snapshot().state, State::kStopping);
  robot.run(0.5);
  EXPECT_EQ(robot.snapshot().end, End::kContact);
}

TEST(RsiDriver, StopsWhereContactCannotBeMindedAnyMore) {
  VirtualRobot robot;
  robot.begin();
  robot.driver->feel(1, robot.now);
  ASSERT_TRUE(robot.move(beside_home(1.0), 2.0, 10));
  robot.run(0.5);  // and /wrench says nothing
  EXPECT_EQ(robot.snapshot().reason, Reason::kNoForce);
  robot.driver->feel(std::nan(""), robot.now);
  ASSERT_TRUE(robot.move(beside_home(1.0), 2.0, 10));
  robot.run(0.05);
  EXPECT_EQ(robot.snapshot().reason, Reason::kContact);  // what is no number is no small force
}

TEST(RsiDriver, LostAnswerMovesNothingTwice) {
  VirtualRobot robot;
  robot.begin();
  ASSERT_TRUE(robot.move(beside_home(1.0), 1.0));
  robot.run(0.4);
  robot.in.set_faults({.dropped = 1});
  robot.step();
  robot.in.set_faults({});
  const Axes held = robot.controller.set_point();
  robot.step();
  EXPECT_EQ(robot.controller.delay(), 1u);
  EXPECT_EQ(robot.controller.set_point(), held);
  robot.step();
  const double step = robot.controller.set_point()[0] - held[0];
  EXPECT_GT(step, 0);
  EXPECT_LT(step, 2.0 * 0.012);  // one cycle's way, at 1.9 rad/s at most
  robot.run(2);
  EXPECT_EQ(robot.snapshot().end, End::kReached);
  EXPECT_EQ(robot.snapshot().late, 1u);
}

TEST(RsiDriver, LostTelegramIsCountedAndMovesNothingTwice) {
  VirtualRobot robot;
  robot.begin();
  ASSERT_TRUE(robot.move(beside_home(1.0), 1.0));
  robot.run(0.4);
  robot.out.set_faults({.dropped = 1});
  robot.step();
  robot.out.set_faults({});
  robot.run(2);
  EXPECT_EQ(robot.snapshot().end, End::kReached);
  EXPECT_EQ(robot.snapshot().missing, 1u);
  EXPECT_EQ(robot.snapshot().late, 0u);
  EXPECT_LT(robot.fastest, 1);
}

TEST(RsiDriver, ManyLostAnswersEndTheMotionUnderControl) {
  VirtualRobot robot;
  robot.begin();
  ASSERT_TRUE(robot.move(beside_home(1.0), 1.0));
  robot.run(0.4);
  robot.in.set_faults({.dropped = 1});
  for (int i = 0; i < 4; ++i) robot.step();
  robot.in.set_faults({});
  robot.run(1);
  EXPECT_EQ(robot.snapshot().state, State::kHolding);
  EXPECT_EQ(robot.snapshot().reason, Reason::kLate);
  EXPECT_LT(robot.arm.actual()[0], 0.6);
  EXPECT_EQ(robot.controller.state(), Controller::State::kRunning);
  EXPECT_TRUE(robot.move(beside_home(1.0), 1.0));  // and goes on when asked to
  robot.run(2);
  EXPECT_EQ(robot.snapshot().end, End::kReached);
}

TEST(RsiDriver, AnswersOfAWrongStampOrTypeAreLate) {
  VirtualRobot robot;
  robot.begin();
  robot.controller.receive(
      R"(<Sen Type="ImFree"><AKorr A1="9" A2="0" A3="0" A4="0" A5="0" A6="0"/><IPOC>12</IPOC></Sen>)",
      robot.now);
  robot.run(0.5);
  EXPECT_EQ(robot.controller.delay(), 0u);
  EXPECT_LT(robot.fastest, 1e-6);
  DriverOptions options;
  options.names.type = "KROSHU";
  VirtualRobot other(options);
  other.begin();
  other.run(0.5);
  EXPECT_EQ(other.controller.state(), Controller::State::kStopped);
  EXPECT_THAT(other.controller.why(), ::testing::HasSubstr("RSI execution error"));
}

TEST(RsiDriver, GoesOnAfterACutThatTheControllerOutlived) {
  ControllerOptions controller = controller_of_kuka();
  controller.late_limit = 500;
  VirtualRobot robot({}, controller);
  robot.begin();
  ASSERT_TRUE(robot.move(beside_home(1.0), 1.0));
  robot.run(0.4);
  robot.in.set_faults({.dropped = 1});
  robot.out.set_faults({.dropped = 1});
  robot.run(2);
  EXPECT_EQ(robot.snapshot().state, State::kSilent);
  EXPECT_EQ(robot.snapshot().reason, Reason::kLost);
  const double held = robot.arm.actual()[0];
  EXPECT_GT(held, 0.1);
  robot.in.set_faults({});
  robot.out.set_faults({});
  robot.fastest = 0;
  robot.run(1);
  EXPECT_EQ(robot.snapshot().state, State::kHolding);
  EXPECT_EQ(robot.snapshot().sessions, 1u);
  EXPECT_LT(robot.fastest, 0.2);  // no jump back to the program's place
  EXPECT_NEAR(robot.arm.actual()[0], held, 0.03);
}

// It cannot know what correction acts; any answer might be a jump.
TEST(RsiDriver, RestartedMidwayItAnswersNothing) {
  for (const bool has_program : {true, false}) {
    ControllerOptions controller = controller_of_kuka();
    controller.sends_program = has_program;
    VirtualRobot robot({}, controller);
    robot.begin();
    ASSERT_TRUE(robot.move(beside_home(0.5), 1.0));
    robot.run(2);
    robot.driver = nullptr;
    robot.run(0.06);
    robot.restart_driver();
    robot.fastest = 0;
    robot.run(0.05);
    EXPECT_EQ(robot.snapshot().state, State::kRefused);
    EXPECT_EQ(robot.snapshot().answers, 0u);
    robot.run(1);
    EXPECT_EQ(robot.controller.state(), Controller::State::kStopped);
    EXPECT_LT(robot.fastest, 0.1);
    EXPECT_NEAR(robot.arm.actual()[0], 0.5, 0.02);
    robot.begin();  // its program is started again
    EXPECT_EQ(robot.snapshot().state, State::kHolding);
    EXPECT_LT(robot.fastest, 0.1);
  }
}

TEST(RsiDriver, TakesTheRsiThatBeginsWhileItRuns) {
  VirtualRobot robot;
  robot.begin();
  ASSERT_TRUE(robot.move(beside_home(0.5), 1.0));
  robot.run(0.5);
  robot.controller.end("emergency stop");
  robot.run(2);
  EXPECT_EQ(robot.snapshot().state, State::kSilent);
  EXPECT_EQ(robot.snapshot().reason, Reason::kLost);
  robot.fastest = 0;
  robot.begin();
  EXPECT_EQ(robot.snapshot().state, State::kHolding);
  EXPECT_EQ(robot.snapshot().sessions, 2u);
  EXPECT_LT(robot.fastest, 0.01);
  ASSERT_TRUE(robot.move(beside_home(0.5), 1.0));
  robot.run(2);
  EXPECT_EQ(robot.snapshot().end, End::kReached);
}

TEST(RsiDriver, TelegramsWithoutWhatItNeedsAreNotAnswered) {
  VirtualRobot robot;
  const std::string axes = R"(<AIPos A1="0" A2="-90" A3="90" A4="0" A5="90" A6="0"/>)";
  for (const std::string& content : {axes, std::string(R"(<Delay D="0"/>)")}) {
    robot.restart_driver();
    for (int i = 0; i < 5; ++i) {
      robot.now += std::chrono::milliseconds(12);
      const std::string ipoc = std::to_string(1000 + 12 * i);
      EXPECT_TRUE(
          robot.driver->on_packet("<Rob>" + content + "<IPOC>" + ipoc + "</IPOC></Rob>", robot.now)
              .empty());
    }
    EXPECT_EQ(robot.snapshot().state, State::kRefused);
    EXPECT_EQ(robot.snapshot().refusal, Reason::kNoSignals);
  }
}

// A set point a telegram would move the arm three times as fast as it was asked to.
TEST(RsiDriver, ControllerOfAShorterCycleThanToldIsNotAnswered) {
  for (const std::uint64_t step : {4, 1}) {
    ControllerOptions controller = controller_of_kuka();
    controller.cycle = controller.answer_time = 0.004;
    controller.ipoc_step = step;
    VirtualRobot robot({}, controller);
    robot.controller.begin();
    for (int i = 0; i < 150 && robot.snapshot().state != State::kRefused; ++i) {
      robot.step();
      EXPECT_NE(robot.snapshot().state, State::kHolding) << step;
    }
    EXPECT_EQ(robot.snapshot().state, State::kRefused) << step;
    EXPECT_EQ(robot.snapshot().refusal, Reason::kCycle) << step;
    EXPECT_FALSE(robot.move(beside_home(0.3), 2));
    robot.run(1);
    EXPECT_EQ(robot.controller.state(), Controller::State::kStopped);
    EXPECT_LT(robot.fastest, 1e-6);
  }
}

// As where the wall clock, by which the kernel stamps, was set while a telegram waited.
TEST(RsiDriver, StampBeforeTheLastTelegramIsNoSilence) {
  VirtualRobot robot;
  std::uint64_t ipoc = 1000;
  const auto telegram = [&](std::chrono::seconds early) {
    robot.now += 12ms;
    ipoc += 12;
    robot.driver->on_time(robot.now);
    const std::string axes = R"(A1="0" A2="-90" A3="90" A4="0" A5="90" A6="0"/>)";
    const std::string text = "<Rob><AIPos " + axes + "<ASPos " + axes + R"(<Delay D="0"/><IPOC>)" +
                             std::to_string(ipoc) + "</IPOC></Rob>";
    return robot.driver->on_packet(text, robot.now - early);
  };
  for (int i = 0; i < 20; ++i) telegram(0s);
  ASSERT_EQ(robot.snapshot().state, State::kHolding);
  EXPECT_FALSE(telegram(5s).empty());
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(telegram(0s).empty());
    EXPECT_EQ(robot.snapshot().state, State::kHolding);
  }
  EXPECT_EQ(robot.snapshot().damaged, 0u);
  EXPECT_EQ(robot.snapshot().sessions, 1u);
}

// A machine or network that was held up hands over what waited at once.
TEST(RsiDriver, TelegramsThatWaitedAreNoShorterCycle) {
  for (const int waited : {5, 20, 35}) {
    for (const int step : {1, 12}) {
      VirtualRobot robot;
      std::uint64_t ipoc = 1000;
      const auto telegram = [&](std::chrono::milliseconds way) {
        robot.now += way;
        ipoc += step;
        const std::string axes = R"(A1="0" A2="-90" A3="90" A4="0" A5="90" A6="0"/>)";
        robot.driver->on_packet("<Rob><AIPos " + axes + "<ASPos " + axes +
                                    R"(<Delay D="0"/><IPOC>)" + std::to_string(ipoc) +
                                    "</IPOC></Rob>",
                                robot.now);
      };
      telegram(12ms);
      for (int i = 0; i < waited; ++i) telegram(0ms);
      EXPECT_EQ(robot.snapshot().state, State::kBeginning) << waited;
      for (int i = 0; i < 60; ++i) telegram(12ms);
      EXPECT_EQ(robot.snapshot().state, State::kHolding) << waited;
    }
  }
}

TEST(RsiDriver, ArmThatDoesNotFollowIsStopped) {
  VirtualRobot robot;
  robot.begin();
  ASSERT_TRUE(robot.move(beside_home(1.0), 1.0));
  // Corrections do not act: as a program that waits in front of RSI_MOVECORR.
  Snapshot last;
  std::uint64_t ipoc = 1000000;
  robot.restart_driver();
  const auto telegram = [&] {
    robot.now += std::chrono::milliseconds(12);
    ipoc += 12;
    const std::string axes = R"(A1="0" A2="-90" A3="90" A4="0" A5="90" A6="0"/>)";
    robot.driver->on_packet("<Rob><AIPos " + axes + "<ASPos " + axes + R"(<Delay D="0"/><IPOC>)" +
                                std::to_string(ipoc) + "</IPOC></Rob>",
                            robot.now);
  };
  for (int i = 0; i < 20; ++i) telegram();
  ASSERT_EQ(robot.snapshot().state, State::kHolding);
  ASSERT_TRUE(robot.move(beside_home(1.0), 1.0));
  for (int i = 0; i < 100; ++i) telegram();
  EXPECT_EQ(robot.snapshot().end, End::kOffPath);
  EXPECT_EQ(robot.snapshot().broken.axis, 0u);
  EXPECT_LT(robot.snapshot().time, 0.8);  // lag and tolerance are over before the goal is told
}

TEST(RsiDriver, OptionsOutOfRangeAreRefused) {
  const auto made = [](const auto& change) {
    DriverOptions options;
    change(options);
    Driver(options, limits_of_kuka());
  };
  EXPECT_THROW(made([](DriverOptions& o) { o.cycle = 0.01; }), std::invalid_argument);
  EXPECT_THROW(made([](DriverOptions& o) { o.lag = 100; }), std::invalid_argument);
  EXPECT_THROW(made([](DriverOptions& o) { o.loss_cycles = 3; }), std::invalid_argument);
  EXPECT_THROW(made([](DriverOptions& o) { o.late_limit = 0; }), std::invalid_argument);
  EXPECT_THROW(made([](DriverOptions& o) { o.settle_time = std::nan(""); }), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::drivers::kuka_rsi
