// What keys do, and what hands are told.

#include "prehend/control/jog_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "prehend/control/hand_motion.h"
#include "prehend/robot/fingertips.h"
#include "prehend/robot/platform.h"

namespace prehend::control {
namespace {

using robot::Platform;
using ::testing::HasSubstr;

constexpr double kSessionPeriod = 0.02;

Platform read_kr5_sdh() { return robot::read_platform("config/robots/kr5_sdh.yaml"); }

class Session {
 public:
  Session()
      : platform(read_kr5_sdh()),
        session(ArmJog(platform.arm_chain(), platform.acceleration,
                       platform.X_FG(platform.hand.preshapes.front())),
                {{"hand_pivot", true, true, 0, 1.5708, 1.4},
                 {"hand_thumb_distal", true, true, -1.5708, 1.5708, 1.4}},
                {14, 14}) {
    now.arm = platform.home("home").arm;
    now.hand = {0.5, 0.2};
  }
  JogCommands step() {
    now.time += kSessionPeriod;
    JogCommands commands = session.step(now);
    if (commands.arm) now.arm = *commands.arm;
    if (commands.hand) {
      now.hand[static_cast<std::size_t>(commands.hand->first)] +=
          commands.hand->second * kSessionPeriod;
    }
    return commands;
  }
  JogCommands type(const std::string& keys) {
    for (const char key : keys) session.key(jog_key(key), now.time);
    return step();
  }
  void settle() {
    for (int i = 0; i < 200; ++i) step();
  }
  Platform platform;
  JogSession session;
  JogPercepts now;
};

TEST(JogSession, OnlyPlusAndMinusMove) {
  Session robot;
  for (int character = 0; character < 256; ++character) {
    const JogKey key = jog_key(character);
    if (key == JogKey::kPlus || key == JogKey::kMinus) continue;
    robot.session.key(key, robot.now.time);
    const JogCommands commands = robot.step();
    EXPECT_FALSE(commands.arm) << character;
    EXPECT_FALSE(commands.hand) << character;
  }
  EXPECT_TRUE(robot.type("+").arm);
  robot.settle();
}

TEST(JogSession, AnyOtherKeyStops) {
  for (const char* key : {" ", "j", "\x7f", "x", "m", "\t"}) {
    Session robot;
    for (int i = 0; i < 30; ++i) robot.type("+");
    const double before = (robot.now.arm - robot.platform.home("home").arm).norm();
    robot.type(key);
    robot.settle();
    EXPECT_FALSE(robot.session.is_moving());
    EXPECT_LT((robot.now.arm - robot.platform.home("home").arm).norm(), before + 0.05) << key;
  }
}

TEST(JogSession, EmergencyAndQuitStopAtOnce) {
  for (const char* key : {"!", "\x1b"}) {
    Session robot;
    robot.type("+++");
    robot.type("+");
    const JogCommands commands = robot.type(key);
    EXPECT_TRUE(commands.emergency);
    EXPECT_TRUE(commands.stop_arm);
    EXPECT_FALSE(commands.arm) << "no set point in the same period";
    EXPECT_FALSE(robot.step().emergency) << "once";
  }
  Session robot;
  EXPECT_TRUE(robot.type("q").quit);
}

TEST(JogSession, ModesAxesRowsAndSpeeds) {
  Session robot;
  EXPECT_EQ(robot.session.rows().size(), 8u);
  robot.type("\t\t");
  EXPECT_EQ(robot.session.row(), 2);
  robot.session.key(JogKey::kPrevious, 0);
  robot.session.key(JogKey::kPrevious, 0);
  robot.session.key(JogKey::kPrevious, 0);
  EXPECT_EQ(robot.session.row(), 7) << "round";
  robot.type("m");
  EXPECT_EQ(robot.session.mode(), JogSession::Kind::kBase);
  robot.type("w");
  EXPECT_EQ(robot.session.axis(), 5);
  const auto before = robot.session.arm().X_BG(robot.now.arm);
  for (int i = 0; i < 20; ++i) robot.type("-");
  const auto after = robot.session.arm().X_BG(robot.now.arm);
  EXPECT_LT((after.translation() - before.translation()).norm(), 1e-6);
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(after.linear() * before.linear().transpose()));
  EXPECT_NEAR((turn.angle() * turn.axis()).normalized().z(), -1, 1e-6);
  robot.type("m");
  EXPECT_EQ(robot.session.mode(), JogSession::Kind::kTool);
  std::set<double> speeds;
  for (int i = 0; i < 12; ++i) {
    robot.type(",");
    speeds.insert(robot.session.speed());
  }
  EXPECT_DOUBLE_EQ(robot.session.speed(), 0.01);
  for (int i = 0; i < 12; ++i) {
    robot.type(".");
    speeds.insert(robot.session.speed());
  }
  EXPECT_DOUBLE_EQ(robot.session.speed(), 1);
  EXPECT_EQ(speeds.size(), 7u);
}

TEST(JogSession, AJointOfTheHandMovesByItsSpeed) {
  Session robot;
  robot.session.key(JogKey::kPrevious, 0);
  JogCommands commands;
  for (int i = 0; i < 30; ++i) commands = robot.type("+");
  ASSERT_TRUE(commands.hand);
  EXPECT_EQ(commands.hand->first, 1);
  EXPECT_NEAR(commands.hand->second, 0.1 * 1.4, 1e-12);
  EXPECT_FALSE(commands.arm);
  bool stopped = false;
  for (int i = 0; i < 20; ++i) stopped = stopped || robot.step().stop_hand;
  EXPECT_TRUE(stopped);
  EXPECT_TRUE(robot.type("o").open_hand);
  EXPECT_TRUE(robot.type("c").close_hand);
  robot.session.key(JogKey::kClose, 0);
  const JogCommands stop = robot.type(" ");
  EXPECT_TRUE(stop.end_hand_motion);
  EXPECT_FALSE(stop.close_hand);
  EXPECT_FALSE(stop.stop_hand) << "what stands may hold something";
}

TEST(JogSession, NothingMovesWhatIsForbiddenAndTheReasonIsSaid) {
  Session robot;
  for (int i = 0; i < 20; ++i) robot.type("+");
  robot.now.forbidden = "emergency stop by the lid: open";
  const JogCommands commands = robot.type("+");
  EXPECT_TRUE(commands.stop_arm);
  EXPECT_FALSE(commands.arm);
  EXPECT_THAT(robot.session.words(), HasSubstr("the lid"));
  EXPECT_FALSE(robot.type("+").arm);
  EXPECT_FALSE(robot.type("c").close_hand);
  robot.now.forbidden.clear();
  EXPECT_FALSE(robot.step().arm) << "no key came since";
  EXPECT_TRUE(robot.type("+").arm);
}

TEST(JogSession, AnArmThatTakesTrajectoriesMovesByRunsThatEndWithTheKey) {
  Session robot;
  robot.now.arm_takes_runs = true;
  const JogCommands begun = robot.type("+");
  ASSERT_GE(begun.run.size(), 50u) << "a second's way";
  EXPECT_FALSE(begun.arm);
  EXPECT_TRUE(robot.session.is_moving());
  const robot::Positions home = robot.now.arm;
  robot::Positions before = home, step = robot::Positions::Zero(6);
  const double most = 0.1 * robot.session.rows()[0].greatest_speed * kSessionPeriod;
  for (const robot::Positions& q : begun.run) {
    EXPECT_LE((q - before).cwiseAbs().maxCoeff(), most * (1 + 1e-9));
    EXPECT_LE((q - before - step).cwiseAbs().maxCoeff(),
              robot.platform.acceleration[0] * kSessionPeriod * kSessionPeriod * (1 + 1e-6));
    step = q - before;
    before = q;
  }
  EXPECT_LT(step.norm(), most * 0.6) << "at its end it rests";
  // The tool's greatest speed is what limits this joint.
  EXPECT_GT(begun.run.back()[0], home[0] + 0.03);
  // While the key is held it is not touched.
  robot.now.arm_runs = true;
  for (int i = 0; i < 20; ++i) {
    const JogCommands commands = robot.type("+");
    EXPECT_FALSE(commands.end_run);
    EXPECT_TRUE(commands.run.empty());
  }
  int until = 0;
  while (!robot.step().end_run) ASSERT_LT(++until, 20);
  EXPECT_TRUE(robot.session.is_moving()) << "it brakes";
  robot.now.arm_runs = false;
  robot.step();
  EXPECT_FALSE(robot.session.is_moving());
  // The next one begins where it stands; another key, silence and the emergency end it.
  for (const char* key : {" ", "-", "!"}) {
    ASSERT_FALSE(robot.type("+").run.empty());
    robot.now.arm_runs = true;
    const JogCommands ended = robot.type(key);
    EXPECT_TRUE(ended.end_run) << key;
    EXPECT_TRUE(ended.run.empty()) << "not before it stands";
    robot.type(" ");
    robot.now.arm_runs = false;
    robot.step();
  }
  ASSERT_FALSE(robot.type("+").run.empty());
  robot.now.arm_runs = true;
  robot.now.arm_age = 1;
  EXPECT_TRUE(robot.type("+").end_run);
}

TEST(HandMotion, AHandClosesByThePreshapeThatItIsNearestTo) {
  const robot::HandModel hand = read_kr5_sdh().hand;
  for (const robot::Preshape& preshape : hand.preshapes) {
    // The rates of cylindrical and spherical are alike, their pivots differ.
    EXPECT_EQ(nearest_preshape(hand, preshape.open).name, preshape.name);
    Eigen::VectorXd half = preshape.open;
    for (Eigen::Index i = 0; i < half.size(); ++i) {
      half[i] += 0.4 * preshape.closing[static_cast<std::size_t>(i)].rate;
    }
    EXPECT_EQ(nearest_preshape(hand, half).name, preshape.name);
  }
}

TEST(HandMotion, ClosingKeepsRatesAndLimits) {
  const robot::HandModel hand = read_kr5_sdh().hand;
  for (const robot::Preshape& preshape : hand.preshapes) {
    const Eigen::VectorXd closed = closed_positions(hand, preshape, preshape.open);
    EXPECT_EQ(hand.limit_problem(hand.all_positions(closed)), "") << preshape.name;
    int at_limit = 0;
    for (Eigen::Index i = 0; i < closed.size(); ++i) {
      const auto& closing = preshape.closing[static_cast<std::size_t>(i)];
      const auto& joint =
          hand.model.joints[static_cast<std::size_t>(hand.actuated[static_cast<std::size_t>(i)])];
      if (closing.rate == 0) {
        EXPECT_EQ(closed[i], preshape.open[i]);
      }
      if (std::min(joint.upper - closed[i], closed[i] - joint.lower) < 1e-12) ++at_limit;
      if (closing.with < 0 || closing.rate == 0) continue;
      const double leader = closed[closing.with] - preshape.open[closing.with];
      const double rate = preshape.closing[static_cast<std::size_t>(closing.with)].rate;
      EXPECT_NEAR((closed[i] - preshape.open[i]) / closing.rate, leader / rate, 1e-12);
    }
    EXPECT_GT(at_limit, 0) << preshape.name;
  }
}

TEST(HandMotion, EffortsDoTheWorkOfTheFingertips) {
  const robot::HandModel hand = read_kr5_sdh().hand;
  const Eigen::VectorXd open = hand.preshape("parallel").open;
  const double force = 5;
  const std::vector<double> efforts = efforts_for(hand, open, force);
  const int motor = hand.actuated_index("thumb_proximal");
  // The way of the fingertip by a small turn, from the links' poses.
  const auto ways = robot::fingertip_ways(hand, open);
  EXPECT_NEAR(efforts[static_cast<std::size_t>(motor)], force * ways.ways.col(motor).norm(), 1e-12);
  EXPECT_GT(efforts[static_cast<std::size_t>(motor)], 0.1);
  EXPECT_THROW(efforts_for(hand, open, 1000), std::invalid_argument);
  EXPECT_THROW(efforts_for(hand, open, -1), std::invalid_argument);
  EXPECT_THROW(efforts_for(hand, open, std::nan("")), std::invalid_argument);
  EXPECT_THROW(efforts_for(hand, Eigen::VectorXd::Zero(2), 1), std::invalid_argument);
  const robot::GripperModel gripper;
  EXPECT_NEAR(current_for(gripper, 22), 1, 1e-12) << "30 N/A less 8 N of friction";
  EXPECT_THROW(current_for(gripper, 500), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::control
