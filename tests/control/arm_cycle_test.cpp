// The cycle of arm and hand, against ports that say what the test wants.

#include <map>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/control/arm_cycle.h"

namespace prehend::control {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Does at once what is asked; keeps it.
struct FakeArm : ArmPort {
  void follow(const JointPath& path, double contact_force) override {
    asked.push_back(path);
    forces.push_back(contact_force);
    position = path.points.back().position;
  }
  MotionStatus motion() override {
    const auto found = says.find(asked.size());
    return found == says.end() ? MotionStatus::kReached : found->second;
  }
  std::string problem() override { return "the arm's words"; }
  void stop() override { ++stops; }
  std::vector<JointPath> asked;
  std::vector<double> forces;
  std::vector<double> position{0.0};
  std::map<std::size_t, MotionStatus> says;  // of the n-th path
  int stops = 0;
};

struct FakeHand : HandPort {
  void move(const std::vector<std::string>&, const std::vector<double>& positions, double,
            bool until_contact) override {
    asked.push_back(positions.front());
    last_closes = until_contact;
  }
  MotionStatus motion() override { return last_closes ? closes : opens; }
  std::string problem() override { return "the hand's words"; }
  void stop() override { ++stops; }
  std::vector<double> asked;
  bool last_closes = false;
  MotionStatus closes = MotionStatus::kContact, opens = MotionStatus::kReached;
  int stops = 0;
};

JointPath path(double from, double to) {
  return {{"j"}, {{0, {from}, {0}, {}}, {2, {to}, {0}, {}}}};
}

ArmGrasp fake_grasp() {
  ArmGrasp grasp;
  grasp.segments = {{"reach", path(0, 1)}, {"approach", path(1, 2)}, {"lift", path(2, 3)},
                    {"carry", path(3, 4)}, {"place", path(4, 5)},    {"retreat", path(5, 6)}};
  grasp.hand_joints = {"f"};
  grasp.open = {0.1};
  grasp.closed = {0.6};
  grasp.lifted_mass = 0.3;
  return grasp;
}

struct Fakes {
  FakeArm arm;
  FakeHand hand;
  ArmPercepts now{0, {"j"}, {0.0}, 3.0};
  void run(ArmCycle& cycle, int steps = 4000) {
    for (int i = 0; i < steps && !cycle.finished(); ++i) {
      now.time += 0.02;
      now.positions = arm.position;
      cycle.step(now);
    }
  }
};

TEST(ArmCycle, RunsTheSegmentsInOrder) {
  Fakes f;
  ArmCycle cycle({}, f.arm, f.hand);
  cycle.step(f.now);
  cycle.start({fake_grasp()});
  f.run(cycle);
  EXPECT_TRUE(cycle.result().success) << cycle.result().reason;
  std::vector<double> ends;
  for (const JointPath& asked : f.arm.asked) ends.push_back(asked.points.back().position[0]);
  EXPECT_THAT(ends, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(f.arm.forces, ElementsAre(0, 0, 0, 0, 0, 0)) << "open loop";
  const ArmCycleOptions defaults;
  EXPECT_THAT(f.hand.asked, ElementsAre(0.1, 0.6 - defaults.gather, 0.6 + defaults.overrun, 0.1));
  ASSERT_EQ(cycle.surprises().size(), 1u);
  EXPECT_FALSE(cycle.surprises()[0].surprising);
  std::vector<std::string> phases;
  for (const auto& [name, seconds] : cycle.phase_times()) phases.push_back(name);
  EXPECT_THAT(phases, ElementsAre("approach", "grasp", "lift", "move", "release", "done"));
}

TEST(ArmCycle, ReactsToContactAndLiftsFromWhereItStopped) {
  Fakes f;
  ArmCycleOptions options;
  options.reacts = true;
  ArmCycle cycle(options, f.arm, f.hand);
  cycle.step(f.now);
  f.arm.says[2] = MotionStatus::kContact;
  cycle.start({fake_grasp()});
  for (int i = 0; i < 4000 && !cycle.finished(); ++i) {
    f.now.time += 0.02;
    f.now.positions = f.arm.position;
    if (f.arm.asked.size() == 2) f.now.positions = {1.8};  // short of 2
    cycle.step(f.now);
  }
  EXPECT_TRUE(cycle.result().success) << cycle.result().reason;
  EXPECT_EQ(f.arm.forces[1], options.contact_force);
  EXPECT_NEAR(f.arm.asked[2].points.front().position[0], 1.8, 1e-12);
  EXPECT_NEAR(f.arm.asked[2].points.back().position[0], 3, 1e-12);
  ASSERT_EQ(cycle.surprises().size(), 2u);
  EXPECT_EQ(cycle.surprises()[0].kind, SurpriseKind::kTouchedTooEarly);
  EXPECT_TRUE(cycle.surprises()[0].surprising);
}

TEST(ArmCycle, GoesBackAndTriesTheNextGrasp) {
  Fakes f;
  ArmCycle cycle({}, f.arm, f.hand);
  f.now.wrist_force = 0.1;  // nothing is held
  cycle.step(f.now);
  cycle.start({fake_grasp(), fake_grasp()});
  f.run(cycle);
  EXPECT_FALSE(cycle.result().success);
  EXPECT_EQ(cycle.result().attempts, 2);
  EXPECT_THAT(cycle.result().reason, HasSubstr("nothing is held"));
  std::vector<double> ends;
  for (const JointPath& asked : f.arm.asked) ends.push_back(asked.points.back().position[0]);
  EXPECT_THAT(ends, ElementsAre(1, 2, 3, 2, 1, 0, 1, 2, 3, 2, 1, 0));
  EXPECT_TRUE(cycle.surprises()[0].surprising);
}

TEST(ArmCycle, LooksAgainFromWhereItBegan) {
  Fakes f;
  ArmCycleOptions options;
  options.look_timeout = 5;
  ArmCycle cycle(options, f.arm, f.hand);
  f.now.wrist_force = 0.1;  // nothing is held
  cycle.step(f.now);
  cycle.start({fake_grasp(), fake_grasp()});
  for (int i = 0; i < 4000 && !cycle.looks_since() && !cycle.finished(); ++i) f.run(cycle, 1);
  ASSERT_TRUE(cycle.looks_since()) << cycle.detail();
  EXPECT_NEAR(f.arm.position[0], 0, 1e-12) << "the arm stands in the camera's view";
  ArmGrasp elsewhere = fake_grasp();
  elsewhere.segments[0].second = path(0, 0.9);
  elsewhere.segments[1].second = path(0.9, 2);
  f.now.wrist_force = 3;
  const std::size_t asked = f.arm.asked.size();
  cycle.take_plan({elsewhere});
  EXPECT_FALSE(cycle.looks_since());
  f.run(cycle);
  EXPECT_TRUE(cycle.result().success) << cycle.result().reason;
  EXPECT_EQ(cycle.result().attempts, 2);
  EXPECT_EQ(cycle.result().plans, 2);
  EXPECT_NEAR(f.arm.asked[asked].points.back().position[0], 0.9, 1e-12);
}

TEST(ArmCycle, WaitsForANewPlanNoLongerThanItWasTold) {
  Fakes f;
  ArmCycleOptions options;
  options.look_timeout = 5;
  ArmCycle cycle(options, f.arm, f.hand);
  f.now.wrist_force = 0.1;
  cycle.step(f.now);
  cycle.start({fake_grasp(), fake_grasp()});
  for (int i = 0; i < 4000 && !cycle.looks_since() && !cycle.finished(); ++i) f.run(cycle, 1);
  ASSERT_TRUE(cycle.looks_since()) << cycle.detail();
  const double since = *cycle.looks_since();
  while (cycle.looks_since() && f.now.time < since + 10) f.run(cycle, 1);
  EXPECT_NEAR(f.now.time - since, options.look_timeout, 0.05);
  EXPECT_THAT(cycle.detail(), HasSubstr("no new plan came"));
  EXPECT_EQ(cycle.grasp_index(), 1);
  for (int i = 0; i < 4000 && !cycle.looks_since() && !cycle.finished(); ++i) f.run(cycle, 1);
  ASSERT_TRUE(cycle.looks_since()) << cycle.detail();
  cycle.take_plan({}, "too wide");
  EXPECT_TRUE(cycle.finished());
  EXPECT_THAT(cycle.result().reason, HasSubstr("too wide"));
}

TEST(ArmCycle, SaysWhatWentWrong) {
  {
    Fakes f;
    ArmCycle cycle({}, f.arm, f.hand);
    cycle.start({}, "object 1: cannot be grasped");
    EXPECT_TRUE(cycle.finished());
    EXPECT_EQ(cycle.result().reason, "object 1: cannot be grasped");
  }
  {
    Fakes f;
    f.hand.closes = MotionStatus::kReached;
    ArmCycle cycle({}, f.arm, f.hand);
    cycle.step(f.now);
    cycle.start({fake_grasp()});
    f.run(cycle);
    EXPECT_THAT(cycle.result().reason, HasSubstr("closed on nothing"));
  }
  {
    Fakes f;
    f.arm.says[1] = MotionStatus::kFailed;
    ArmCycle cycle({}, f.arm, f.hand);
    cycle.step(f.now);
    cycle.start({fake_grasp()});
    f.run(cycle);
    EXPECT_FALSE(cycle.result().success);
    EXPECT_THAT(cycle.result().reason, HasSubstr("the arm's words"));
  }
  {
    Fakes f;
    f.arm.says[1] = MotionStatus::kMoving;
    ArmCycle cycle({}, f.arm, f.hand);
    cycle.step(f.now);
    cycle.start({fake_grasp()});
    f.run(cycle);
    EXPECT_THAT(cycle.result().reason, HasSubstr("too long"));
    EXPECT_GT(f.arm.stops, 0);
  }
  {
    Fakes f;
    f.arm.position = {2.0};  // far from where the plan begins
    f.now.positions = {2.0};
    ArmCycle cycle({}, f.arm, f.hand);
    cycle.step(f.now);
    cycle.start({fake_grasp()});
    f.run(cycle);
    EXPECT_THAT(cycle.result().reason, HasSubstr("from where the plan begins"));
    EXPECT_TRUE(f.arm.asked.empty());
  }
  ArmCycleOptions options;
  options.closing_speed = 2;
  FakeArm arm;
  FakeHand hand;
  EXPECT_THROW(ArmCycle(options, arm, hand), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::control
