// Whatever falls silent, in whatever phase: motion stops, and that is the reason that is given.
// Once a cycle whose gripper did not answer any more lifted, carried and lowered for 8 s, and one
// whose force sensor was silent reported full success.

#include <limits>
#include <string>
#include <tuple>

#include <gmock/gmock.h>

#include "prehend/control/arm_cycle.h"
#include "tests/control/gripper_cycle_fixture.h"

namespace prehend::control {
namespace {

using ::testing::HasSubstr;

struct Input {
  const char* name;      // in FakeWorld
  const char* in_words;  // of the reason
  double limit;          // s
};

class LostInput : public GripperCycleTest,
                  public testing::WithParamInterface<std::tuple<Input, Phase>> {};

TEST_P(LostInput, StopsAllMotionAndIsTheReason) {
  const auto& [input, phase] = GetParam();
  double lost_at = -1;
  run(3, [&, phase = phase, name = input.name] {
    if (lost_at >= 0 || cycle.phase() != phase) return;
    // Not where the phase ends just then.
    if (std::string(name).ends_with("motion") && !world.arm_moving()) return;
    world.silence(name);
    lost_at = world.percepts().time;
  });
  ASSERT_GE(lost_at, 0) << "the cycle never was in that phase";
  EXPECT_FALSE(cycle.result().success());
  EXPECT_THAT(cycle.result().reason, HasSubstr(std::string("lost ") + input.in_words));
  EXPECT_NEAR(world.percepts().time - lost_at, input.limit, 0.05);
  EXPECT_TRUE(world.stopped()) << "the jaws go on";
  EXPECT_FALSE(world.arm_moving()) << "the stage goes on";
  EXPECT_EQ(cycle.result().attempts, 1) << "it tried another grasp";
}

const ArmCycleOptions kDefaults;

INSTANTIATE_TEST_SUITE_P(
    Sensors, LostInput,
    testing::Combine(testing::Values(Input{"gripper", "the gripper's state", kDefaults.stale_time},
                                     Input{"left", "the left pad's frames", kDefaults.stale_time},
                                     Input{"right", "the right pad's frames", kDefaults.stale_time},
                                     Input{"wrist", "the wrist's force", kDefaults.stale_time},
                                     Input{"joints", "the joints' states", kDefaults.stale_time}),
                     testing::Values(Phase::kApproach, Phase::kGrasp, Phase::kLift, Phase::kMove,
                                     Phase::kRelease)));

INSTANTIATE_TEST_SUITE_P(
    Servers, LostInput,
    testing::Combine(testing::Values(Input{"arm motion", "the server of the arm's motion",
                                           kDefaults.answer_time}),
                     testing::Values(Phase::kApproach, Phase::kLift, Phase::kMove)));

TEST_F(GripperCycleTest, AGripperWhoseServerIsGoneStopsTheCycle) {
  run(3, [&] { world.silence("gripper motion"); });
  EXPECT_THAT(cycle.result().reason, HasSubstr("lost the server of the hand's motion"));
  EXPECT_TRUE(world.stopped());
}

TEST_F(GripperCycleTest, WaitsForWhatHasNotSpokenYet) {
  cycle.start({grasp_at(0)});
  for (int i = 0; i < 300; ++i) {
    ArmPercepts percepts = world.percepts();
    percepts.wrist_force.reset();
    cycle.step(percepts);
    world.advance();
  }
  EXPECT_EQ(cycle.phase(), Phase::kWaiting);
  EXPECT_EQ(cycle.detail(), "waiting for the wrist's force");
  for (int i = 0; i < 20000 && !cycle.finished(); ++i) {
    cycle.step(world.percepts());
    world.advance();
  }
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
}

/// Moves for `duration` s of the cycle's clock; says so, until it is silent.
struct SlowArm : ArmPort {
  void follow(const JointTrajectory& path, double) override {
    end = now + 1;
    position = path.points.back().position;
    moving = true;
  }
  MotionStatus motion() override {
    if (now >= end && !gone) moving = false;
    return moving ? MotionStatus::kMoving : MotionStatus::kReached;
  }
  double answer_age() override { return gone ? std::numeric_limits<double>::infinity() : 0; }
  std::string problem() override { return ""; }
  void stop() override { moving = false; }
  double now = 0, end = 0;
  bool moving = false, gone = false;
  std::vector<double> position{0.0};
};

struct QuickHand : HandPort {
  void move(const std::vector<std::string>&, const std::vector<double>&, double, bool until_contact,
            const std::vector<double>&) override {
    closes = until_contact;
    stopped = false;
  }
  MotionStatus motion() override {
    return closes ? MotionStatus::kContact : MotionStatus::kReached;
  }
  std::string problem() override { return ""; }
  std::vector<double> positions() override { return {}; }
  void stop() override { stopped = true; }
  bool closes = false, stopped = false;
};

ArmGrasp grasp_of_one_joint() {
  const auto way = [](double from, double to) -> JointTrajectory {
    return {{"j"}, {{0, {from}, {0}, {}}, {1, {to}, {0}, {}}}};
  };
  ArmGrasp grasp;
  using motion::SegmentKind;
  grasp.segments = {{SegmentKind::kReach, way(0, 1)}, {SegmentKind::kApproach, way(1, 2)},
                    {SegmentKind::kLift, way(2, 3)},  {SegmentKind::kCarry, way(3, 4)},
                    {SegmentKind::kPlace, way(4, 5)}, {SegmentKind::kRetreat, way(5, 6)}};
  grasp.hand_joints = {"f"};
  const auto one = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  grasp.hand = {one(0.1), one(0.6), one(1), one(0), one(2)};
  grasp.lifted_mass = 0.3;
  return grasp;
}

class ArmLostInput : public testing::TestWithParam<std::tuple<std::string, Phase>> {
 protected:
  // Runs to the end; `each_step` may change what is perceived.
  void run(const std::function<void(ArmPercepts&)>& each_step) {
    ArmPercepts now{0, {"j"}, {0.0}, Eigen::Vector3d::Zero()};
    cycle.step(now);
    cycle.start({grasp_of_one_joint(), grasp_of_one_joint()});
    for (int i = 0; i < 5000 && !cycle.finished(); ++i) {
      now.time += 0.02;
      arm.now = now.time;
      now.positions = arm.position;
      now.wrist_force = Eigen::Vector3d(0, 0, hand.closes ? 3 : 0);
      each_step(now);
      cycle.step(now);
    }
    ASSERT_TRUE(cycle.finished()) << cycle.detail();
  }
  SlowArm arm;
  QuickHand hand;
  ArmCycle cycle{{}, arm, hand};
};

TEST_P(ArmLostInput, StopsAllMotionAndIsTheReason) {
  const auto& [input, phase] = GetParam();
  double lost_at = -1, now = 0;
  run([&, input = input, phase = phase](ArmPercepts& percepts) {
    now = percepts.time;
    if (lost_at < 0 && cycle.phase() == phase && (input != "arm" || arm.moving)) lost_at = now;
    if (lost_at < 0) return;
    if (input == "joints") percepts.joints_age = now - lost_at;
    if (input == "wrist") percepts.wrist_age = now - lost_at;
    if (input == "arm") arm.gone = true;
  });
  const ArmCycleOptions options;
  const std::map<std::string, std::string> words{{"joints", "lost the joints' states"},
                                                 {"wrist", "lost the wrist's force"},
                                                 {"arm", "lost the server of the arm's motion"}};
  ASSERT_GE(lost_at, 0);
  EXPECT_FALSE(cycle.result().success());
  EXPECT_THAT(cycle.result().reason, HasSubstr(words.at(input)));
  EXPECT_LE(now - lost_at, options.stale_time + 0.05);
  EXPECT_FALSE(arm.moving);
  EXPECT_TRUE(hand.stopped);
  EXPECT_EQ(cycle.result().attempts, 1);
}

INSTANTIATE_TEST_SUITE_P(Inputs, ArmLostInput,
                         testing::Combine(testing::Values("joints", "wrist", "arm"),
                                          testing::Values(Phase::kApproach, Phase::kLift,
                                                          Phase::kMove)));

TEST_F(ArmLostInput, SucceedsWithAllOfThem) {
  run([](ArmPercepts&) {});
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
}

TEST_F(ArmLostInput, WaitsForTheWristAndSaysSo) {
  ArmPercepts now{0, {"j"}, {0.0}, std::nullopt};
  cycle.step(now);
  cycle.start({grasp_of_one_joint()});
  for (int i = 0; i < 100; ++i) {
    now.time += 0.02;
    cycle.step(now);
  }
  EXPECT_EQ(cycle.phase(), Phase::kWaiting);
  EXPECT_EQ(cycle.detail(), "waiting for the wrist's force");
  for (int i = 0; i < 5000 && !cycle.finished(); ++i) {
    now.time += 0.02;
    cycle.step(now);
  }
  EXPECT_THAT(cycle.result().reason, HasSubstr("the wrist's force (nothing has come)"));
  EXPECT_EQ(cycle.result().attempts, 0);
}

}  // namespace
}  // namespace prehend::control
