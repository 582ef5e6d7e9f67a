// Tasks as the cycle carries them out, with a gripper that feels its grip and with fingers.

#include <algorithm>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/control/arm_cycle_fixture.h"
#include "tests/control/gripper_cycle_fixture.h"
#include "tests/control/tasks.h"

namespace prehend::control {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class TaskOfTheGripper : public GripperCycleTest {
 protected:
  void step(ArmCycle& driven) {
    driven.step(world.percepts());
    world.advance();
  }
  void run_until_it_looks(ArmCycle& driven) {
    for (int i = 0; i < 60000 && !driven.finished() && !driven.looks_since(); ++i) step(driven);
    ASSERT_TRUE(driven.looks_since()) << driven.detail();
  }
};

TEST_F(TaskOfTheGripper, WorkCyclePutsItBackWhereItStood) {
  ArmCycle working{doing(task_named("work_cycle")), arm, hand};
  working.start({grasp_at(0)});
  run_to_the_end(working);
  EXPECT_TRUE(working.result().success()) << working.result().reason;
  EXPECT_THAT(states_of(working), ElementsAre("look", "approach", "grasp", "lift", "move_down",
                                              "release", "leave", "success"));
  EXPECT_NEAR(world.highest_object(), 0.15, 1e-3);
  EXPECT_NEAR(world.p_WG().y(), 0, 1e-9) << "it was not carried";
  EXPECT_EQ(working.result().placed, 0);
}

TEST_F(TaskOfTheGripper, ShakesFiveTimes) {
  ArmCycle shaking{doing(task_named("shake_test")), arm, hand};
  shaking.start({grasp_at(0)});
  int ways = 0;
  bool high = false;
  for (int i = 0; i < 60000 && !shaking.finished(); ++i) {
    step(shaking);
    const bool now = world.object_height() > 0.1001;
    ways += now != high ? 1 : 0;
    high = now;
  }
  EXPECT_TRUE(shaking.result().success()) << shaking.result().reason;
  EXPECT_EQ(ways, 2 + 2 * 5) << "lifted, five times down and up, lowered";
}

TEST_F(TaskOfTheGripper, WhatIsLostInAShakeIsALoss) {
  world.lost_when_carried = false;
  ArmCycle shaking{doing(task_named("shake_test")), arm, hand};
  shaking.start({grasp_at(0)});
  for (int i = 0; i < 60000 && !shaking.finished(); ++i) {
    if (shaking.detail() == "lifting it again") world.object_width = 0;
    step(shaking);
  }
  EXPECT_FALSE(shaking.result().success());
  EXPECT_THAT(shaking.result().reason, HasSubstr("lost while lifting"));
}

TEST_F(TaskOfTheGripper, ClearsTheTableOfEveryObject) {
  const Eigen::Vector3d start = world.p_WG();
  ArmCycle clearing{doing(task_named("clear_table")), arm, hand};
  clearing.start({grasp_at(0)});
  run_until_it_looks(clearing);
  EXPECT_TRUE(clearing.any_object());
  EXPECT_EQ(clearing.result().placed, 1);
  EXPECT_TRUE(world.p_WG().isApprox(start, 1e-6)) << "it stands in the camera's view";
  clearing.take_plan({grasp_at(0.1)});
  run_until_it_looks(clearing);
  EXPECT_EQ(clearing.result().placed, 2);
  clearing.take_plan({}, "none is left");
  EXPECT_TRUE(clearing.result().success()) << clearing.result().reason;
  EXPECT_THAT(clearing.result().reason, HasSubstr("2 objects were put at their place"));
  EXPECT_THAT(clearing.result().reason, HasSubstr("none is left"));
}

TEST_F(TaskOfTheGripper, GoesOnWithTheOthersWhereOneCannotBeHeld) {
  ArmCycle clearing{doing(task_named("clear_table")), arm, hand};
  world.object_is_anywhere = false;
  world.object_x = 0.2;
  clearing.start({grasp_at(0)});
  for (int attempt = 0; attempt < 2; ++attempt) {
    run_until_it_looks(clearing);
    EXPECT_FALSE(clearing.any_object()) << "the same object again";
    clearing.take_plan({grasp_at(0.03 * (attempt + 1))});
  }
  run_until_it_looks(clearing);
  EXPECT_TRUE(clearing.any_object());
  EXPECT_EQ(clearing.given_up(), 1);
  clearing.take_plan({grasp_at(0.2)});
  run_until_it_looks(clearing);
  EXPECT_EQ(clearing.result().placed, 1);
  // It lies otherwise, perhaps, now that another is gone.
  EXPECT_EQ(clearing.given_up(), 0);
  world.object_x = 0.2;
  for (int attempt = 0; attempt < 3; ++attempt) {
    clearing.take_plan({grasp_at(0.03 * attempt)});
    run_until_it_looks(clearing);
  }
  EXPECT_TRUE(clearing.any_object());
  EXPECT_EQ(clearing.given_up(), 1);
  clearing.take_plan({}, "none is left");
  EXPECT_FALSE(clearing.result().success()) << "one was given up";
  EXPECT_THAT(clearing.result().reason, HasSubstr("1 given up"));
}

TEST_F(TaskOfTheGripper, TouchesWithoutClosing) {
  const Task touching = parse_task(R"(start: look
states:
  look: {do: look, done: touch, otherwise: failure}
  touch: {do: touch, done: rest, nothing: leave_it, failed: leave_it}
  rest: {do: wait, seconds: 0.5, done: back}
  leave_it: {do: release, done: back_in_vain, failed: failure}
  back: {do: retreat, done: success, failed: failure}
  back_in_vain: {do: retreat, done: failure, failed: failure}
)",
                                   "touching.yaml");
  world.obstacle_height = 0.06;
  ArmCycle cautious{doing(touching), arm, hand};
  cautious.start({grasp_at(0)});
  double before = 0;
  for (int i = 0; i < 60000 && !cautious.finished(); ++i) {
    if (cautious.detail() == "arm: approach") before = world.percepts().time;
    step(cautious);
  }
  EXPECT_TRUE(cautious.result().success()) << cautious.result().reason;
  EXPECT_THAT(states_of(cautious), ElementsAre("look", "touch", "rest", "back", "success"));
  EXPECT_GT(world.percepts().time - before, 0.5);
  for (const Surprise& surprise : cautious.surprises()) EXPECT_FALSE(surprise.surprising);
  world.obstacle_height = -1;
  ArmCycle in_vain{doing(touching), arm, hand};
  in_vain.start({grasp_at(0)});
  run_to_the_end(in_vain);
  EXPECT_FALSE(in_vain.result().success());
}

TEST_F(TaskOfTheGripper, FeelsFirstWhereThePlanSaysSo) {
  ArmCycle deciding{doing(task_named("decide_and_pick")), arm, hand};
  deciding.start({grasp_at(0), grasp_at(0.001)}, "", {Advice::Act::kTouch, 1, "feel it"});
  double most_felt = 0;
  bool felt = false;
  for (int i = 0; i < 60000 && !deciding.finished(); ++i) {
    step(deciding);
    felt = felt || deciding.result().touches == 1;
    if (deciding.result().attempts > 0) continue;
    EXPECT_LE(deciding.grasp_index(), 1);
    for (const PadPercept& pad : world.percepts().pads) most_felt = std::max(most_felt, pad.sum);
  }
  EXPECT_TRUE(deciding.result().success()) << deciding.result().reason;
  EXPECT_TRUE(felt);
  EXPECT_EQ(deciding.result().touches, 1);
  EXPECT_EQ(deciding.result().attempts, 1) << "what is felt is no attempt";
  EXPECT_GT(most_felt, 0.3) << "it was touched";
  EXPECT_LT(most_felt, 6) << "and not gripped, where 12 N are wanted";
  EXPECT_THAT(states_of(deciding), ElementsAre("look", "decide", "reach", "feel", "let_go", "back",
                                               "look", "decide", "approach", "grasp", "lift",
                                               "carry", "put_down", "release", "leave", "success"));
}

// An object that may be felt once is not felt again, whatever the next plan says.
TEST_F(TaskOfTheGripper, FeelsNoMoreThanItMay) {
  ArmCycleOptions options = doing(task_named("decide_and_pick"));
  options.look_timeout = 5;
  ArmCycle deciding{options, arm, hand};
  const Advice touch{Advice::Act::kTouch, 0, "feel it"};
  deciding.start({grasp_at(0)}, "", touch);
  run_until_it_looks(deciding);
  EXPECT_FALSE(deciding.any_object()) << "the same object";
  EXPECT_THAT(deciding.detail(), HasSubstr("felt it"));
  deciding.take_plan({grasp_at(0)}, "", touch);
  run_to_the_end(deciding);
  EXPECT_TRUE(deciding.result().success()) << deciding.result().reason;
  EXPECT_EQ(deciding.result().touches, 1);
  EXPECT_EQ(deciding.result().plans, 2);
}

ArmGrasp pushing(ArmGrasp grasp) {
  grasp.pushes = true;
  grasp.segments.resize(2);
  return grasp;
}

// Where nothing can be grasped things are pushed, looked at, and picked when that has helped.
TEST_F(TaskOfTheGripper, PushesWhatCannotBeGraspedAsItStands) {
  ArmCycle clearing{doing(task_named("clear_table")), arm, hand};
  world.obstacle_height = 0.06;  // m: what it pushes, on the way
  clearing.start({pushing(grasp_at(0))}, "between others");
  bool pushed = false;
  for (int i = 0; i < 60000 && !clearing.finished() && !clearing.looks_since(); ++i) {
    pushed = pushed || clearing.phase() == Phase::kPush;
    step(clearing);
  }
  ASSERT_TRUE(clearing.looks_since()) << clearing.result().reason;
  EXPECT_TRUE(pushed);
  EXPECT_TRUE(clearing.any_object());
  EXPECT_EQ(clearing.result().pushes, 1);
  EXPECT_EQ(clearing.result().attempts, 0) << "a push is no attempt";
  EXPECT_NEAR(world.height(), 0.4, 0.01) << "out of the view";
  world.obstacle_height = -1;
  clearing.take_plan({grasp_at(0)});
  run_until_it_looks(clearing);
  EXPECT_EQ(clearing.result().placed, 1);
  clearing.take_plan({}, "none is left");
  EXPECT_TRUE(clearing.result().success()) << clearing.result().reason;
  EXPECT_THAT(states_of(clearing),
              ElementsAre("look", "push", "back", "look", "approach", "grasp", "lift", "carry",
                          "put_down", "release", "back", "look", "push", "success"));
}

TEST_F(TaskOfTheGripper, PushesNoMoreThanItMayWhileNothingIsPutDown) {
  ArmCycleOptions options = doing(task_named("clear_table"));
  options.largest_pushes = 2;
  ArmCycle clearing{options, arm, hand};
  clearing.start({pushing(grasp_at(0))}, "between others");
  for (int push = 0; push < 2; ++push) {
    run_until_it_looks(clearing);
    clearing.take_plan({pushing(grasp_at(0.01 * push))}, "still between others");
  }
  EXPECT_TRUE(clearing.finished());
  EXPECT_EQ(clearing.result().pushes, 2);
  EXPECT_THAT(clearing.result().reason,
              AllOf(HasSubstr("still between others"), HasSubstr("largest_pushes")));
  // A push of before is not done again when a look has none.
  ArmCycle once{doing(task_named("clear_table")), arm, hand};
  once.start({pushing(grasp_at(0))}, "between others");
  run_until_it_looks(once);
  once.take_plan({}, "it is too wide");
  EXPECT_TRUE(once.finished());
  EXPECT_EQ(once.result().pushes, 1);
  EXPECT_THAT(once.result().reason, HasSubstr("too wide"));
  // Nor is it where nobody looks.
  ArmCycleOptions blind = doing(task_named("clear_table"));
  blind.look_timeout = 0;
  ArmCycle unseeing{blind, arm, hand};
  unseeing.start({pushing(grasp_at(0))}, "between others");
  run_to_the_end(unseeing);
  EXPECT_EQ(unseeing.result().pushes, 1);
  // Nor where the look does not come.
  ArmCycleOptions impatient = doing(task_named("clear_table"));
  impatient.look_timeout = 0.5;
  ArmCycle waiting{impatient, arm, hand};
  waiting.start({pushing(grasp_at(0))}, "between others");
  run_to_the_end(waiting);
  EXPECT_EQ(waiting.result().pushes, 1);
  EXPECT_THAT(waiting.result().reason, HasSubstr("no new plan came"));
  // A task that does not push ends without grasps, as ever.
  ArmCycle picking{doing(task_named("pick_and_place")), arm, hand};
  picking.start({pushing(grasp_at(0))}, "between others");
  EXPECT_TRUE(picking.finished());
  EXPECT_THAT(picking.result().reason, HasSubstr("between others"));
}

// Regression: it was said of a grasp, and was the attempt that came furthest.
TEST(TaskOfFingers, APushThatFailsIsNoAttemptThatFailed) {
  Fakes f;
  ArmCycle clearing(doing(task_named("clear_table")), f.arm, f.hand);
  f.arm.says[1] = MotionStatus::kFailed;
  clearing.start({pushing(fake_grasp())}, "between others");
  f.hand.closes = MotionStatus::kReached;  // on nothing
  std::string said;
  for (int i = 0; i < 8000 && !clearing.finished(); ++i) {
    f.now.time += 0.02;
    clearing.step(f.felt());
    if (said.empty() && clearing.phase() == Phase::kRelease) said = clearing.detail();
    if (clearing.looks_since() && clearing.result().attempts < 3) {
      clearing.take_plan({fake_grasp()});
    }
  }
  EXPECT_THAT(said, HasSubstr("push along the table: arm: reach"));
  EXPECT_EQ(clearing.result().attempts, 3);
  EXPECT_FALSE(clearing.result().success());
  EXPECT_THAT(clearing.result().reason, HasSubstr("no grasp succeeded in 3 attempts"));
  EXPECT_EQ(clearing.result().reason.find("push along"), std::string::npos)
      << clearing.result().reason;
}

ArmGrasp probing(ArmGrasp grasp) {
  grasp.probe_H = Eigen::Vector3d(0, 0.03, 0.1);
  return grasp;
}

// A fingertip goes where the plan's probe leads, and what stops it is told.
TEST_F(TaskOfTheGripper, ProbesWhatItThenPicks) {
  for (const double obstacle : {0.06, -1.0}) {  // m: met on the way, or not
    SCOPED_TRACE(obstacle);
    world.obstacle_height = obstacle;
    ArmCycle cycle_of{doing(task_named("probe_and_pick")), arm, hand};
    cycle_of.start({grasp_at(0), probing(grasp_at(0.02))});
    bool met = false;
    for (int i = 0; i < 60000 && !cycle_of.finished(); ++i) {
      step(cycle_of);
      if (!cycle_of.met_with_H()) continue;
      met = true;
      EXPECT_EQ(cycle_of.phase(), Phase::kApproach);
      EXPECT_FALSE(world.arm_moving());
      EXPECT_NEAR(cycle_of.met_with_H()->y(), 0.03, 1e-12);
      world.obstacle_height = -1;
    }
    EXPECT_EQ(met, obstacle > 0);
    EXPECT_TRUE(cycle_of.result().success()) << cycle_of.result().reason;
    EXPECT_EQ(cycle_of.result().touches, 1);
    EXPECT_EQ(cycle_of.result().attempts, 1) << "a probe is no attempt";
    EXPECT_EQ(cycle_of.result().grasp_index, 0);
    EXPECT_THAT(states_of(cycle_of),
                ElementsAre("look", "probe", "back", "look", "probe", "approach", "grasp", "lift",
                            "carry", "put_down", "release", "leave", "success"));
  }
}

// Regression: what a probe found out was no attempt, and the words for none crashed.
TEST_F(TaskOfTheGripper, AfterAProbeALookThatGivesNoGraspIsSaid) {
  ArmCycleOptions options = doing(task_named("probe_and_pick"));
  options.only_seen_again = true;
  options.look_timeout = 5;
  ArmCycle cycle_of{options, arm, hand};
  cycle_of.start({grasp_at(0), probing(grasp_at(0.02))});
  for (int i = 0; i < 60000 && !cycle_of.finished(); ++i) {
    cycle_of.step(world.percepts());
    world.advance();
    if (cycle_of.looks_since()) cycle_of.take_plan({}, "it is too wide now");
  }
  EXPECT_FALSE(cycle_of.result().success());
  EXPECT_THAT(cycle_of.result().reason,
              AllOf(HasSubstr("no grasp was tried"), HasSubstr("it is too wide now")));
}

TEST_F(TaskOfTheGripper, PicksAtOnceWhatNoFingertipCanProbe) {
  ArmCycle cycle_of{doing(task_named("probe_and_pick")), arm, hand};
  cycle_of.start({grasp_at(0)});
  run_to_the_end(cycle_of);
  EXPECT_TRUE(cycle_of.result().success()) << cycle_of.result().reason;
  EXPECT_EQ(cycle_of.result().touches, 0);
  EXPECT_EQ(states_of(cycle_of)[2], "approach");
}

// A pad that feels more than before stops it, too, one that always feels something does not.
TEST_F(TaskOfTheGripper, APadThatTouchesStopsAProbe) {
  for (const double offset : {0.0, 1.0}) {
    SCOPED_TRACE(offset);
    ArmCycle cycle_of{doing(task_named("probe_and_pick")), arm, hand};
    cycle_of.start({grasp_at(0), probing(grasp_at(0.02))});
    bool met = false;
    double stopped_at = 0;
    for (int i = 0; i < 60000 && !cycle_of.finished() && !met; ++i) {
      ArmPercepts percepts = world.percepts();
      for (PadPercept& pad : percepts.pads) {
        pad.sum += offset;
        if (cycle_of.detail() == "arm: approach" && world.height() < 0.05) pad.sum += 0.5;
      }
      cycle_of.step(percepts);
      world.advance();
      met = cycle_of.met_with_H().has_value();
      stopped_at = world.height();
    }
    EXPECT_TRUE(met) << cycle_of.result().reason;
    EXPECT_NEAR(stopped_at, 0.05, 0.01);
  }
}

TEST_F(TaskOfTheGripper, ProbesWhereThePlanSaysThatThisIsWorthIt) {
  ArmCycle deciding{doing(task_named("decide_and_pick")), arm, hand};
  deciding.start({grasp_at(0), probing(grasp_at(0.02))}, "", {Advice::Act::kProbe, 0, "probe it"});
  run_to_the_end(deciding);
  EXPECT_TRUE(deciding.result().success()) << deciding.result().reason;
  EXPECT_EQ(deciding.result().touches, 1);
  EXPECT_THAT(states_of(deciding), ElementsAre("look", "decide", "reach", "feel", "let_go", "back",
                                               "look", "decide", "approach", "grasp", "lift",
                                               "carry", "put_down", "release", "leave", "success"));
}

// An arm that does not come there is no reason to leave what can be grasped.
TEST_F(TaskOfTheGripper, AProbeThatFailsIsNoAttempt) {
  ArmCycleOptions options = doing(task_named("probe_and_pick"));
  options.motion_timeout = 20;
  ArmCycle cycle_of{options, arm, hand};
  cycle_of.start({grasp_at(0), probing(grasp_at(0.02))});
  for (int i = 0; i < 60000 && !cycle_of.finished(); ++i) {
    world.arm_stuck = cycle_of.detail() == "arm: approach" && cycle_of.grasp_index() == 1;
    step(cycle_of);
  }
  EXPECT_TRUE(cycle_of.result().success()) << cycle_of.result().reason;
  EXPECT_EQ(cycle_of.result().touches, 1);
}

TEST_F(TaskOfTheGripper, LeavesWhatIsNotWorthAnAttempt) {
  ArmCycle deciding{doing(task_named("decide_and_pick")), arm, hand};
  deciding.start({grasp_at(0)}, "", {Advice::Act::kGiveUp, 0, "leave it: worth -3 s"});
  run_to_the_end(deciding);
  EXPECT_FALSE(deciding.result().success());
  EXPECT_THAT(deciding.result().reason, HasSubstr("leave it: worth -3 s"));
  EXPECT_THAT(states_of(deciding), ElementsAre("look", "decide", "failure"));
  EXPECT_EQ(deciding.result().attempts, 0);
}

TEST(TaskOfTheArm, FingersThatFeelDoNotPress) {
  Fakes f;
  ArmCycle cycle(doing(task_named("decide_and_pick"), {}), f.arm, f.hand);
  cycle.step(f.now);
  cycle.start({fake_grasp(), fake_grasp()}, "", {Advice::Act::kTouch, 0, "feel it"});
  f.run(cycle);
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  EXPECT_EQ(cycle.result().touches, 1);
  EXPECT_EQ(cycle.result().attempts, 1);
}

TEST(TaskOfTheArm, WorkCycleGoesBackTheWayItCame) {
  Fakes f;
  ArmCycle cycle(doing(task_named("work_cycle"), {}), f.arm, f.hand);
  cycle.step(f.now);
  cycle.start({fake_grasp()});
  f.run(cycle);
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  EXPECT_THAT(cycle.result().reason, HasSubstr("put down where it stood"));
  std::vector<double> ends;
  for (const JointTrajectory& asked : f.arm.asked) ends.push_back(asked.points.back().position[0]);
  EXPECT_THAT(ends, ElementsAre(1, 2, 3, 2, 1, 0)) << "reach, approach, lift, and back";
}

TEST(TaskOfTheArm, ShakesAlongItsLift) {
  Fakes f;
  ArmCycle cycle(doing(task_named("shake_test"), {}), f.arm, f.hand);
  cycle.step(f.now);
  cycle.start({fake_grasp()});
  f.run(cycle);
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  std::vector<double> ends;
  for (const JointTrajectory& asked : f.arm.asked) {
    ends.push_back(std::round(100 * asked.points.back().position[0]) / 100);
  }
  EXPECT_THAT(ends, ElementsAre(1, 2, 3, 2.5, 3, 2.5, 3, 2.5, 3, 2.5, 3, 2.5, 3, 2, 1, 0));
}

TEST(TaskOfTheArm, ClearsTheTableOfEveryObject) {
  Fakes f;
  ArmCycle cycle(doing(task_named("clear_table"), {}), f.arm, f.hand);
  cycle.step(f.now);
  cycle.start({fake_grasp()});
  for (int object = 1; object <= 2; ++object) {
    for (int i = 0; i < 4000 && !cycle.looks_since() && !cycle.finished(); ++i) f.run(cycle, 1);
    ASSERT_TRUE(cycle.looks_since()) << cycle.detail();
    EXPECT_TRUE(cycle.any_object());
    EXPECT_EQ(cycle.result().placed, object);
    if (object == 2) break;
    // Planned from where the arm stands.
    ArmGrasp next = fake_grasp();
    next.segments[0].second = path(6, 1);
    cycle.take_plan({next});
  }
  cycle.take_plan({}, "none is left");
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  EXPECT_THAT(cycle.result().reason, HasSubstr("2 objects were put at their place"));
}

TEST(TaskOfTheArm, APlanWithoutAPlaceIsPutBack) {
  Fakes f;
  ArmCycleOptions options = doing(task_named("sort"), {});
  options.largest_attempts = 1;
  ArmCycle cycle(options, f.arm, f.hand);
  cycle.step(f.now);
  ArmGrasp grasp = fake_grasp();
  grasp.segments.resize(3);
  cycle.start({grasp});
  for (int i = 0; i < 4000 && !cycle.looks_since() && !cycle.finished(); ++i) f.run(cycle, 1);
  ASSERT_TRUE(cycle.looks_since()) << cycle.detail();
  EXPECT_EQ(cycle.given_up(), 1);
  EXPECT_EQ(f.arm.position[0], 0) << "lowered again, and back where it began";
  cycle.take_plan({}, "none is left");
  EXPECT_FALSE(cycle.result().success());
  EXPECT_THAT(cycle.result().reason, HasSubstr("not put at its place"));
}

TEST(JointPathPart, EndsAtRestWhereThePathIsByThen) {
  const JointTrajectory half = part_of(path(2, 3), 0.5);
  EXPECT_NEAR(half.points.front().position[0], 2, 1e-12);
  EXPECT_NEAR(half.points.back().position[0], 2.5, 1e-12);
  EXPECT_NEAR(half.points.back().velocity[0], 0, 1e-12);
  double peak = 0;
  for (std::size_t i = 1; i < half.points.size(); ++i) {
    const auto &a = half.points[i - 1], &b = half.points[i];
    peak = std::max(peak, (b.position[0] - a.position[0]) / (b.time - a.time));
    EXPECT_LE(b.velocity[0], 0.5 * (1 + 1e-9)) << "the path's speed";
  }
  EXPECT_NEAR(peak, 0.5, 0.01);
  EXPECT_EQ(part_of(path(2, 3), 1).points.size(), 2u);
}

}  // namespace
}  // namespace prehend::control
