// prehend jog in a terminal, at a simulated robot: it moves while keys come, and stops.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "msgs/actions.pb.h"
#include "msgs/safety.pb.h"
#include "tests/tools/jogged_robot.h"
#include "tests/tools/pseudo_terminal.h"

namespace prehend::testing {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kDown = "\x1b[B";  // the arrow key, as xterm sends it

class Jog : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { robot_ = std::make_unique<JoggedRobot>("kr5_sdh"); }
  static void TearDownTestSuite() { robot_.reset(); }

  static JoggedRobot& robot() { return *robot_; }
  static std::vector<std::string> words() { return {"jog", "--speed", "0.5"}; }

  /// Keys as a held one repeats them, until `condition`.
  static bool hold(PseudoTerminal& terminal, const std::string& key,
                   const std::function<bool()>& condition) {
    const auto end = std::chrono::steady_clock::now() + 30s;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end) return false;
      terminal.type(key);
      std::this_thread::sleep_for(25ms);
    }
    return true;
  }
  static void expect_quits(PseudoTerminal& terminal) {
    terminal.type("q");
    EXPECT_EQ(terminal.wait(20s), 0) << terminal.shown();
  }
  static std::unique_ptr<JoggedRobot> robot_;
};
std::unique_ptr<JoggedRobot> Jog::robot_;

TEST_F(Jog, MovesWhileAKeyIsHeldAndStandsWhenItCeases) {
  PseudoTerminal terminal("prehend", words(), robot().registry());
  ASSERT_TRUE(terminal.shows("EMERGENCY STOP")) << terminal.shown();
  EXPECT_THAT(terminal.shown(), AllOf(HasSubstr("kr5_sdh (node simulation)"), HasSubstr("axis_1"),
                                      HasSubstr("thumb_distal"), HasSubstr("tool in world")));
  const double start = robot().position("arm_axis_1");
  ASSERT_TRUE(hold(terminal, "+", [&] { return robot().position("arm_axis_1") > start + 0.05; }));
  ASSERT_TRUE(robot().stands());
  const double there = robot().position("arm_axis_1");
  EXPECT_LT(there, start + 0.5);
  std::this_thread::sleep_for(300ms);
  EXPECT_NEAR(robot().position("arm_axis_1"), there, 1e-3);
  // Back, in the base's frame: the tool goes along y alone.
  ASSERT_TRUE(hold(terminal, "-", [&] { return robot().position("arm_axis_1") < start; }));
  ASSERT_TRUE(robot().stands());
  terminal.type("m");
  terminal.type("z");
  EXPECT_TRUE(terminal.shows("CARTESIAN in the base: x y [z] roll pitch yaw"));
  const double shoulder = robot().position("arm_axis_2");
  ASSERT_TRUE(hold(terminal, "+", [&] {
    return std::abs(robot().position("arm_axis_2") - shoulder) > 0.02;
  })) << terminal.shown();
  ASSERT_TRUE(robot().stands());
  // A joint of the hand, the last one.
  terminal.type("mm");
  terminal.type("\x1b[A");
  EXPECT_TRUE(terminal.shows("JOINT thumb_distal"));
  const double finger = robot().position("hand_thumb_distal");
  ASSERT_TRUE(
      hold(terminal, "-", [&] { return robot().position("hand_thumb_distal") < finger - 0.05; }));
  EXPECT_TRUE(robot().stands());
  expect_quits(terminal);
  EXPECT_THAT(terminal.wrote(), HasSubstr("\x1b[?1049l")) << "the screen is given back";
}

TEST_F(Jog, StandsAtTheLimitAndSaysSo) {
  PseudoTerminal terminal("prehend", {"jog", "--speed", "1"}, robot().registry());
  ASSERT_TRUE(terminal.shows("EMERGENCY STOP"));
  // The hand's roll: nothing is in its way.
  for (int i = 0; i < 5; ++i) terminal.type(kDown);
  ASSERT_TRUE(terminal.shows("JOINT axis_6"));
  const double limit = 6.2483;
  ASSERT_TRUE(hold(terminal, "+", [&] {
    return terminal.shown().find("limit of joint 'arm_axis_6', 358.0 deg") != std::string::npos &&
           robot().position("arm_axis_6") > limit - 1e-3;
  })) << terminal.shown();
  EXPECT_LE(robot().position("arm_axis_6"), limit + 1e-4);
  ASSERT_TRUE(hold(terminal, "-", [&] { return robot().position("arm_axis_6") < 5.5; }));
  expect_quits(terminal);
  EXPECT_TRUE(robot().stands());
}

TEST_F(Jog, KilledWhileItMovesTheArmBrakesByItself) {
  PseudoTerminal terminal("prehend", words(), robot().registry());
  ASSERT_TRUE(terminal.shows("EMERGENCY STOP"));
  const double start = robot().position("arm_axis_1");
  ASSERT_TRUE(hold(terminal, "+", [&] { return robot().velocity("arm_axis_1") > 0.05; }));
  ::kill(terminal.pid(), SIGKILL);
  ASSERT_TRUE(robot().stands());
  EXPECT_LT(robot().position("arm_axis_1"), start + 1);
  EXPECT_TRUE(eventually([&] {
    return robot().said().find("no arm command for 0.2 s while moving: stopped") !=
           std::string::npos;
  })) << robot().said();
}

TEST_F(Jog, TheEmergencyKeyStopsEachDeviceWhereThereIsNoNodeForIt) {
  PseudoTerminal terminal("prehend", words(), robot().registry());
  ASSERT_TRUE(terminal.shows("EMERGENCY STOP"));
  ASSERT_TRUE(hold(terminal, "-", [&] { return robot().velocity("arm_axis_1") < -0.05; }));
  terminal.type("!");
  EXPECT_TRUE(terminal.shows("there is no node emergency_stop; /arm/stop done; /hand/stop done"))
      << terminal.shown();
  EXPECT_TRUE(robot().stands());
  expect_quits(terminal);
}

TEST_F(Jog, TheEmergencyKeyAsksTheNodeForItAndNothingMovesThen) {
  // Of its own: what has heard an emergency stop and hears it no more stays stopped.
  JoggedRobot own("kr5_sdh");
  std::mutex mutex;
  msgs::EmergencyStopRequest asked;
  graph::NodeOptions options;
  options.name = "emergency_stop";
  options.registry = own.registry();
  graph::Node node(options);
  const auto stopped =
      node.advertise<msgs::EmergencyStop>("/emergency_stop", graph::QoS::latched(1));
  std::atomic<bool> is_stopped = false;
  const auto service = node.serve<msgs::EmergencyStopRequest, msgs::Acknowledge>(
      "/emergency_stop/stop", [&](const msgs::EmergencyStopRequest& request) {
        const std::lock_guard lock(mutex);
        asked = request;
        is_stopped = true;
        msgs::Acknowledge answer;
        answer.set_success(true);
        return answer;
      });
  const auto timer = node.create_timer(0.05, [&] {
    msgs::EmergencyStop state;
    state.set_stopped(is_stopped);
    state.set_source(is_stopped ? "prehend jog" : "");
    state.set_reason("a key");
    stopped.publish(state);
  });
  node.spin_in_background();
  PseudoTerminal terminal("prehend", words(), own.registry());
  ASSERT_TRUE(terminal.shows("EMERGENCY STOP"));
  ASSERT_TRUE(hold(terminal, "+", [&] { return own.velocity("arm_axis_1") > 0.05; }));
  terminal.type("\x1b");
  ASSERT_TRUE(eventually([&] { return is_stopped.load(); }));
  {
    const std::lock_guard lock(mutex);
    EXPECT_EQ(asked.source(), "prehend jog");
    EXPECT_THAT(asked.reason(), HasSubstr("key"));
  }
  EXPECT_TRUE(terminal.shows("NOTHING MOVES: emergency stop by prehend jog: a key"));
  ASSERT_TRUE(own.stands());
  const double there = own.position("arm_axis_1");
  for (int i = 0; i < 20; ++i) {
    terminal.type("+");
    std::this_thread::sleep_for(20ms);
  }
  EXPECT_NEAR(own.position("arm_axis_1"), there, 1e-4);
  expect_quits(terminal);
}

// As the driver of a KUKA is.
TEST_F(Jog, AnArmThatTakesTrajectoriesAloneMovesByTheseWhileAKeyIsHeld) {
  JoggedRobot other("kr5_pg70", {"--remap", "/arm/command:=/unused/arm/command"});
  PseudoTerminal terminal("prehend", words(), other.registry());
  ASSERT_TRUE(terminal.shows("nobody takes /arm/command: the arm moves by /arm/follow"));
  const double start = other.position("arm_axis_1");
  // More than one trajectory's way.
  ASSERT_TRUE(hold(terminal, "+", [&] { return other.position("arm_axis_1") > start + 0.3; }));
  ASSERT_TRUE(other.stands());
  const double there = other.position("arm_axis_1");
  EXPECT_LT(there, start + 0.6);
  // The other way, and killed: its goal goes with it.
  ASSERT_TRUE(hold(terminal, "-", [&] { return other.velocity("arm_axis_1") < -0.1; }));
  ::kill(terminal.pid(), SIGKILL);
  EXPECT_TRUE(other.stands());
  EXPECT_GT(other.position("arm_axis_1"), start);
}

TEST_F(Jog, OpensAndClosesTheHandAndASpaceEndsIt) {
  PseudoTerminal terminal("prehend", {"jog", "--speed", "0.2", "--preshape", "parallel"},
                          robot().registry());
  ASSERT_TRUE(terminal.shows("EMERGENCY STOP"));
  terminal.type("c");
  ASSERT_TRUE(terminal.shows("the hand closes until it presses"));
  EXPECT_TRUE(eventually([&] { return robot().velocity("hand_thumb_proximal") > 0.05; }));
  terminal.type(" ");
  EXPECT_TRUE(robot().stands());
  terminal.type("o");
  EXPECT_TRUE(terminal.shows("hand: there"));
  EXPECT_NEAR(robot().position("hand_thumb_proximal"), -0.45, 0.02);
  expect_quits(terminal);
}

TEST_F(Jog, RefusesTerminalsThatAreNone) {
  ScratchDirectory folder;
  ChildProgram program("prehend", words(), folder.path("out"), robot().registry());
  EXPECT_EQ(program.wait(20s), 1);
  EXPECT_THAT(program.output(), HasSubstr("prehend jog: standard input and output must be a "
                                          "terminal"));
  for (const char* kind : {"dumb", "no-such-terminal", ""}) {
    PseudoTerminal terminal("prehend", words(), robot().registry(), kind);
    EXPECT_EQ(terminal.wait(20s), 1) << kind;
    EXPECT_THAT(terminal.wrote(), AllOf(HasSubstr("prehend jog: the terminal '"), HasSubstr(kind),
                                        HasSubstr("TERM")));
  }
  // Without colours it is the same.
  PseudoTerminal plain("prehend", words(), robot().registry(), "vt100");
  EXPECT_TRUE(plain.shows("EMERGENCY STOP"));
  expect_quits(plain);
}

TEST_F(Jog, EndsWithItsTerminal) {
  auto terminal = std::make_unique<PseudoTerminal>("prehend", words(), robot().registry());
  ASSERT_TRUE(terminal->shows("EMERGENCY STOP"));
  ASSERT_TRUE(hold(*terminal, "-", [&] { return robot().velocity("arm_axis_1") < -0.05; }));
  ::kill(terminal->pid(), SIGHUP);
  EXPECT_EQ(terminal->wait(20s), 0);
  EXPECT_TRUE(robot().stands());
}

}  // namespace
}  // namespace prehend::testing
