// Motion by held keys: exact straight steps, every limit, the dead man.

#include "prehend/control/jog.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <Eigen/Geometry>

#include "prehend/control/jog_space.h"
#include "prehend/motion/nearness.h"
#include "prehend/robot/platform.h"

namespace prehend::control {
namespace {

using geometry::RigidTransform;
using robot::Platform;
using robot::Positions;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Kind = JogMotion::Kind;

constexpr double kPeriod = 0.02;

Platform platform_named(const std::string& name) {
  return robot::read_platform("config/robots/" + name + ".yaml");
}

std::shared_ptr<const motion::RobotInWorld> space_of(const Platform& platform) {
  return jog_space(platform, platform.hand.all_positions(platform.hand.preshapes.front().open));
}

/// A robot that is where it was told to be.
class Jogged {
 public:
  explicit Jogged(const std::string& name, double share = 0.2)
      : platform(platform_named(name)),
        jog(platform.arm_chain(), platform.acceleration,
            platform.X_FG(platform.hand.preshapes.front())),
        q(platform.home("home").arm) {
    jog.set_speed(share);
  }
  JogStep step(double age = 0) {
    const JogStep step = jog.step(q, age, time);
    time += kPeriod;
    if (step.set_point) q = *step.set_point;
    return step;
  }
  /// So many periods with the key held.
  JogStep hold(const JogMotion& motion, int steps) {
    JogStep last;
    for (int i = 0; i < steps; ++i) {
      jog.press(motion, time);
      last = step();
    }
    return last;
  }
  /// Until it stands.
  void release() {
    for (int i = 0; i < 500 && jog.is_moving(); ++i) step();
    ASSERT_FALSE(jog.is_moving());
  }
  Platform platform;
  ArmJog jog;
  Positions q;
  double time = 0;
};

RigidTransform moved(const RigidTransform& X, Kind kind, int axis, double way) {
  const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis % 3);
  RigidTransform result = X;
  if (axis < 3) {
    result.translation() += way * (kind == Kind::kTool ? X.linear() * unit : unit);
    return result;
  }
  const Eigen::Matrix3d R = Eigen::AngleAxisd(way, unit).toRotationMatrix();
  result.linear() = kind == Kind::kTool ? (X.linear() * R).eval() : (R * X.linear()).eval();
  return result;
}

TEST(ArmJog, TheToolGoesAsAskedInEachStep) {
  for (const char* name : {"kr5_pg70", "kr5_sdh", "pa10_barrett"}) {
    for (const Kind kind : {Kind::kBase, Kind::kTool}) {
      for (int axis = 0; axis < 6; ++axis) {
        Jogged robot(name);
        const RigidTransform start = robot.jog.X_BG(robot.q);
        double way = 0;
        for (int i = 0; i < 40; ++i) {
          robot.jog.press({kind, axis, i < 25 ? 1.0 : -1.0}, robot.time);
          const JogStep step = robot.step();
          ASSERT_TRUE(step.set_point) << name;
          way += step.speed * kPeriod;
          const RigidTransform wanted = moved(start, kind, axis, way);
          ASSERT_LT((robot.jog.X_BG(robot.q).matrix() - wanted.matrix()).cwiseAbs().maxCoeff(),
                    1e-6)
              << name << " axis " << axis << " step " << i;
        }
        EXPECT_GT(std::abs(way), 1e-3) << name << " axis " << axis;
      }
    }
  }
}

TEST(ArmJog, NoLimitIsExceededWhateverKeysCome) {
  std::mt19937 random(7);
  for (const char* name : {"stage_pg70", "kr5_sdh", "pa10_barrett"}) {
    Jogged robot(name, 1);
    const auto space = space_of(robot.platform);
    robot.jog.set_space(space);
    ASSERT_GE(motion::nearness(*space, robot.q).distance, 0) << name << " at home";
    const auto& joints = robot.jog.chain().joints();
    JogMotion motion;
    double farthest = 0;
    for (int i = 0; i < 1500; ++i) {
      if (i % 30 == 0) {
        motion.kind = static_cast<Kind>(random() % 3);
        motion.axis = static_cast<int>(
            random() % (motion.kind == Kind::kJoint ? joints.size() : std::size_t{6}));
        motion.sign = random() % 2 == 0 ? 1 : -1;
        robot.jog.set_speed(random() % 2 == 0 ? 1.0 : 0.3);
      }
      const Positions before = robot.q;
      robot.jog.press(motion, robot.time);
      robot.step();
      ASSERT_TRUE(robot.jog.chain().within_limits(robot.q, 0)) << name << " step " << i;
      for (int j = 0; j < robot.jog.chain().size(); ++j) {
        ASSERT_LE(std::abs(robot.q[j] - before[j]) / kPeriod,
                  joints[static_cast<std::size_t>(j)].max_velocity * (1 + 1e-6))
            << name << " step " << i;
      }
      const double tool_speed =
          (robot.jog.X_BG(robot.q).translation() - robot.jog.X_BG(before).translation()).norm() /
          kPeriod;
      ASSERT_LE(tool_speed, robot.jog.options().linear_speed * 1.001) << name << " step " << i;
      ASSERT_GE(motion::nearness(*space, robot.q).distance, -1e-8) << name << " step " << i;
      farthest = std::max(farthest, (robot.q - robot.platform.home("home").arm).norm());
    }
    EXPECT_GT(farthest, 0.2) << name << " got somewhere";
  }
}

TEST(ArmJog, StopsWithinOnePeriodWithoutKeysAndThenCommandsNothing) {
  Jogged robot("kr5_pg70");
  const double share = robot.jog.speed();
  const JogMotion motion{Kind::kJoint, 5, 1};
  const double full = robot.hold(motion, 60).speed;
  EXPECT_NEAR(full, share * robot.jog.chain().joints()[5].max_velocity, 1e-9);
  const double last_key = robot.time - kPeriod;
  // The key counts for its hold time, and not a period longer.
  while (robot.time < last_key + robot.jog.options().hold_time) {
    EXPECT_NEAR(robot.step().speed, full, 1e-9);
  }
  double before = full, stop_way = 0;
  const double a = robot.platform.acceleration[5];
  for (JogStep step = robot.step(); step.speed > 0; step = robot.step()) {
    EXPECT_NEAR(step.speed, before - a * kPeriod, 1e-9) << "brakes from the first period on";
    before = step.speed;
    stop_way += step.speed * kPeriod;
  }
  EXPECT_LE(stop_way, full * full / (2 * a));
  robot.release();
  const JogStep nothing = robot.step();
  EXPECT_FALSE(nothing.set_point);
  EXPECT_FALSE(nothing.ended);
  // A last set point is followed by one stop.
  robot.hold(motion, 3);
  int ends = 0;
  for (int i = 0; i < 100; ++i) {
    const JogStep step = robot.step();
    ends += step.ended;
    EXPECT_FALSE(step.ended && step.set_point);
  }
  EXPECT_EQ(ends, 1);
}

TEST(ArmJog, StandsAtTheLimitAndSaysWhich) {
  Jogged robot("kr5_pg70", 1);
  const JogStep last = robot.hold({Kind::kJoint, 0, -1}, 800);
  EXPECT_NEAR(robot.q[0], robot.jog.chain().joints()[0].lower, 1e-4);
  EXPECT_TRUE(robot.jog.chain().within_limits(robot.q, 0));
  EXPECT_NEAR(last.speed, 0, 1e-3);
  EXPECT_EQ(last.hindrance, JogHindrance::kLimit);
  EXPECT_THAT(last.words, HasSubstr("limit of joint 'arm_axis_1', -170.0 deg"));
  // Back it goes at once.
  const JogStep back = robot.hold({Kind::kJoint, 0, 1}, 20);
  EXPECT_EQ(back.hindrance, JogHindrance::kNone);
  EXPECT_GT(back.speed, 0.05);
  // Where it stands a little beyond a limit, set points begin at the limit.
  robot.release();
  robot.q[0] = robot.jog.chain().joints()[0].lower - 1e-3;
  EXPECT_TRUE(robot.hold({Kind::kJoint, 0, 1}, 5).set_point);
  EXPECT_TRUE(robot.jog.chain().within_limits(robot.q, 0));
}

TEST(ArmJog, SlowsDownBeforeTheTableStopsAndNamesThePair) {
  Jogged robot("stage_pg70", 1);
  const auto space = space_of(robot.platform);
  robot.jog.set_space(space);
  JogStep last;
  double fastest = 0;
  const int down = 2;
  // The stage's z grows downwards or upwards: towards the table is where the tool sinks.
  Positions probe = robot.q;
  probe[down] += 0.01;
  const double sign =
      robot.jog.X_BG(probe).translation().z() < robot.jog.X_BG(robot.q).translation().z() ? 1 : -1;
  for (int i = 0; i < 600; ++i) {
    last = robot.hold({Kind::kJoint, down, sign}, 1);
    fastest = std::max(fastest, std::abs(last.speed));
  }
  EXPECT_GT(fastest, 0.2);
  const double near = motion::nearness(*space, robot.q).distance;
  EXPECT_GE(near, 0);
  EXPECT_LT(near, 2e-3) << "it came there";
  EXPECT_EQ(last.hindrance, JogHindrance::kNear);
  EXPECT_THAT(last.words, AllOf(HasSubstr("the link of joint 'arm_yaw' and 'table'"),
                                HasSubstr("would touch")));
  const Positions low = robot.q;
  robot.hold({Kind::kJoint, down, -sign}, 30);
  EXPECT_GT(sign * (low[down] - robot.q[down]), 0.01);
  EXPECT_EQ(robot.hold({Kind::kJoint, 0, 1}, 10).hindrance, JogHindrance::kNone) << "beside it";
}

TEST(ArmJog, WhatTouchesAlreadyMayGoAwayButNoNearer) {
  Jogged robot("stage_pg70", 0.5);
  JogSurroundings around;
  around.table = 0.28;  // the fingers are below it
  robot.q[2] = 0.2;
  const auto space =
      jog_space(robot.platform,
                robot.platform.hand.all_positions(robot.platform.hand.preshapes[0].open), around);
  robot.jog.set_space(space);
  ASSERT_LT(motion::nearness(*space, robot.q).distance, 0);
  const Positions start = robot.q;
  int ways = 0;
  for (const double sign : {1.0, -1.0}) {
    robot.q = start;
    const JogStep last = robot.hold({Kind::kJoint, 2, sign}, 10);
    robot.release();
    const double change =
        motion::nearness(*space, robot.q).distance - motion::nearness(*space, start).distance;
    EXPECT_GE(change, -1e-5);
    if (change > 1e-3) ++ways;
    if (change < 1e-3) {
      EXPECT_EQ(last.hindrance, JogHindrance::kNear);
    }
  }
  EXPECT_EQ(ways, 1);
}

TEST(ArmJog, KeepsItsLineToTheEndOfItsReachAndStopsThere) {
  for (const char* name : {"kr5_pg70", "pa10_barrett"}) {
    Jogged robot(name, 0.5);
    const RigidTransform start = robot.jog.X_BG(robot.q);
    JogStep last;
    double way = 0, off = 0;
    for (int i = 0; i < 1500; ++i) {
      last = robot.hold({Kind::kBase, 0, 1}, 1);
      way += last.speed * kPeriod;
      const RigidTransform wanted = moved(start, Kind::kBase, 0, way);
      off =
          std::max(off, (robot.jog.X_BG(robot.q).matrix() - wanted.matrix()).cwiseAbs().maxCoeff());
    }
    EXPECT_LT(off, 1e-6) << name;
    EXPECT_GT(way, 0.1) << name;
    EXPECT_LT(std::abs(last.speed), 5e-3) << name << " stands, or creeps";
    EXPECT_NE(last.hindrance, JogHindrance::kNone) << name;
    EXPECT_FALSE(last.words.empty()) << name;
  }
}

TEST(ArmJog, ThroughASingularPositionItSlowsDownButStaysOnItsLine) {
  // The wrist's axes 4 and 6 in line: turning about the tool's x asks axis 4 for a leap.
  Jogged robot("kr5_pg70", 0.1);
  robot.q[4] = 0.02;
  const RigidTransform start = robot.jog.X_BG(robot.q);
  double way = 0;
  bool slowed = false;
  for (int i = 0; i < 200; ++i) {
    const Positions before = robot.q;
    const JogStep step = robot.hold({Kind::kTool, 3, 1}, 1);
    way += step.speed * kPeriod;
    slowed =
        slowed || step.hindrance == JogHindrance::kSpeed || step.hindrance == JogHindrance::kCannot;
    const RigidTransform wanted = moved(start, Kind::kTool, 3, way);
    ASSERT_LT((robot.jog.X_BG(robot.q).matrix() - wanted.matrix()).cwiseAbs().maxCoeff(), 1e-6);
    for (int j = 0; j < 6; ++j) {
      ASSERT_LE(std::abs(robot.q[j] - before[j]),
                0.1 * robot.jog.chain().joints()[static_cast<std::size_t>(j)].max_velocity *
                    kPeriod * (1 + 1e-6));
    }
  }
  EXPECT_TRUE(slowed);
}

TEST(ArmJog, WhatAnArmCannotItIsNotMadeToDo) {
  Jogged stage("stage_pg70");
  const Positions home = stage.q;
  for (const int axis : {3, 4}) {
    const JogStep last = stage.hold({Kind::kBase, axis, 1}, 10);
    EXPECT_EQ(last.speed, 0);
    EXPECT_EQ(last.hindrance, JogHindrance::kCannot);
    EXPECT_THAT(last.words, HasSubstr(axis == 3 ? "about x" : "about y"));
    stage.release();
  }
  EXPECT_EQ(stage.q, home);
  EXPECT_GT(std::abs(stage.hold({Kind::kBase, 5, 1}, 10).speed), 0.01);
}

TEST(ArmJog, StopsWhereJointsAreNotToldOrDoNotFollow) {
  Jogged robot("kr5_pg70");
  const JogMotion motion{Kind::kJoint, 1, 1};
  EXPECT_EQ(robot.jog.step({}, 0, 0).hindrance, JogHindrance::kNone) << "nothing is asked for";
  robot.jog.press(motion, 0);
  EXPECT_EQ(robot.jog.step({}, 0, 0.001).hindrance, JogHindrance::kSilent);
  robot.time = 1;
  robot.hold(motion, 10);
  robot.jog.press(motion, robot.time);
  const JogStep silent = robot.step(0.5);
  EXPECT_TRUE(silent.ended);
  EXPECT_FALSE(silent.set_point);
  EXPECT_THAT(silent.words, HasSubstr("0.5 s ago"));
  // A number that is none.
  Positions broken = robot.q;
  broken[3] = std::numeric_limits<double>::quiet_NaN();
  robot.jog.press(motion, robot.time);
  EXPECT_FALSE(robot.jog.step(broken, 0, robot.time).set_point);
  // Somebody holds it.
  const Positions stuck = robot.q;
  JogStep last;
  int steps = 0;
  for (; steps < 500 && !last.ended; ++steps) {
    robot.jog.press(motion, robot.time);
    last = robot.jog.step(stuck, 0, robot.time);
    robot.time += kPeriod;
  }
  EXPECT_TRUE(last.ended);
  EXPECT_EQ(last.hindrance, JogHindrance::kDoesNotFollow);
  EXPECT_THAT(last.words, HasSubstr("joint 'arm_axis_2' does not follow"));
  EXPECT_LT(steps, 100);
}

TEST(ArmJog, DoesNotGoOnAfterItWasHeldUp) {
  Jogged robot("kr5_pg70");
  const JogMotion motion{Kind::kJoint, 0, 1};
  ASSERT_GT(robot.hold(motion, 40).speed, 0.01);
  robot.time += 1;
  robot.jog.press(motion, robot.time);
  const JogStep held = robot.step();
  EXPECT_TRUE(held.ended);
  EXPECT_FALSE(held.set_point);
  EXPECT_THAT(held.words, HasSubstr("held up for 1.0 s"));
  EXPECT_GT(robot.hold(motion, 40).speed, 0.01) << "and anew";
}

TEST(ArmJog, AnotherKeyBeginsWhenTheFirstMotionHasStopped) {
  Jogged robot("kr5_pg70");
  robot.hold({Kind::kJoint, 5, 1}, 40);
  for (int i = 0; i < 40; ++i) {
    const Positions before = robot.q;
    robot.hold({Kind::kJoint, 4, 1}, 1);
    const Positions way = robot.q - before;
    EXPECT_TRUE(way[5] == 0 || way[4] == 0) << "one at a time";
  }
  EXPECT_GT(robot.q[4], robot.platform.home("home").arm[4]);
}

TEST(ArmJog, RefusesWhatIsNone) {
  Jogged robot("stage_pg70");
  EXPECT_THROW(robot.jog.press({Kind::kJoint, 4, 1}, 0), std::invalid_argument);
  EXPECT_THROW(robot.jog.press({Kind::kBase, 6, 1}, 0), std::invalid_argument);
  EXPECT_THROW(robot.jog.press({Kind::kBase, 0, 0.5}, 0), std::invalid_argument);
  EXPECT_THROW(robot.jog.set_speed(0), std::invalid_argument);
  EXPECT_THROW(robot.jog.set_speed(std::nan("")), std::invalid_argument);
  JogOptions options;
  options.hold_time = -1;
  EXPECT_THROW(options.validate(), std::invalid_argument);
  EXPECT_THROW(ArmJog(robot.platform.arm_chain(), Positions::Ones(3), RigidTransform::Identity()),
               std::invalid_argument);
  JogSurroundings around;
  around.clearance = std::nan("");
  EXPECT_THROW(jog_space(robot.platform,
                         robot.platform.hand.all_positions(Eigen::VectorXd::Zero(1)), around),
               std::invalid_argument);
}

TEST(AxisJog, MovesWhileTheKeyIsPressedAndSlowsDownBeforeTheEnd) {
  const AxisJog::Axis axis{0, 0.069, 0.083, 0.32};
  AxisJog jog(axis);
  double position = 0.03, time = 0, fastest = 0;
  for (int i = 0; i < 200; ++i, time += kPeriod) {
    jog.press(1, time);
    const AxisJog::Step step = jog.step(position, 0, 1, time);
    if (step.speed) position += *step.speed * kPeriod;
    fastest = std::max(fastest, step.speed.value_or(0));
    ASSERT_LE(position, axis.upper + 1e-9);
  }
  EXPECT_DOUBLE_EQ(fastest, axis.greatest_speed);
  EXPECT_NEAR(position, axis.upper, 5e-4);
  jog.press(1, time);
  EXPECT_EQ(jog.step(position, 0, 1, time).hindrance, JogHindrance::kLimit);
  // Released: one stop, then nothing.
  jog.press(-1, time);
  EXPECT_LT(*jog.step(0.03, 0, 0.5, time).speed, 0);
  time += JogOptions().hold_time;
  EXPECT_TRUE(jog.step(0.03, 0, 0.5, time).ended);
  EXPECT_FALSE(jog.step(0.03, 0, 0.5, time + kPeriod).ended);
  // Not told where it is.
  jog.press(1, time);
  const AxisJog::Step silent = jog.step(std::nan(""), 0, 1, time);
  EXPECT_FALSE(silent.speed);
  EXPECT_EQ(silent.hindrance, JogHindrance::kSilent);
  EXPECT_THROW(AxisJog({1, 0, 1, 1}), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::control
