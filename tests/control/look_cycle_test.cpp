// The cycle brings the camera that the arm carries to another side of what it is to pick.

#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/control/gripper_cycle_fixture.h"
#include "tests/control/tasks.h"

namespace prehend::control {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class LooksOfTheGripper : public GripperCycleTest {
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

// From where the arm stands to 0.1 m beside it, as a plan's look leads.
Advice look_aside(const ArmGrasp& grasp) {
  JointTrajectory way = grasp.segments.front().second;
  const std::vector<double> start = way.points.front().position;
  const double duration = way.duration();
  for (JointTrajectory::Point& point : way.points) {
    const double s = point.time / duration;
    point.position = start;
    point.position[1] += 0.1 * s * s * (3 - 2 * s);
    point.velocity.clear();
    point.acceleration.clear();
  }
  return {Advice::Act::kLook, 0, "look at it from the left first", way};
}

ArmCycleOptions deciding_with_looks() {
  ArmCycleOptions options = doing(task_named("decide_and_pick"));
  options.look_timeout = 5;
  return options;
}

// A grasp that was planned while the arm stood at the end of look_aside().
ArmGrasp from_aside(ArmGrasp grasp) {
  std::vector<JointTrajectory::Point>& reach = grasp.segments.front().second.points;
  reach.front().position[1] += 0.1;
  for (JointTrajectory::Point& point : reach) {
    point.velocity.clear();
    point.acceleration.clear();
  }
  return grasp;
}

// It looks from there, decides anew by what is seen, and looks no more than it may.
TEST_F(LooksOfTheGripper, LooksFromElsewhereWhereThePlanSaysSo) {
  ArmCycle deciding{deciding_with_looks(), arm, hand};
  const Eigen::Vector3d start = world.p_WG();
  const Advice look = look_aside(grasp_at(0));
  deciding.start({grasp_at(0)}, "", look);
  run_until_it_looks(deciding);
  EXPECT_NEAR((world.p_WG() - start).norm(), 0.1, 1e-3) << "where it is looked from";
  EXPECT_FALSE(world.arm_moving());
  EXPECT_FALSE(deciding.any_object());
  EXPECT_EQ(deciding.result().looks, 1);
  deciding.take_plan({from_aside(grasp_at(0))}, "", look);
  EXPECT_FALSE(deciding.looks_since());
  run_to_the_end(deciding);
  EXPECT_TRUE(deciding.result().success()) << deciding.result().reason;
  EXPECT_EQ(deciding.result().looks, 1);
  EXPECT_EQ(deciding.result().attempts, 1) << "a look is no attempt";
  EXPECT_EQ(deciding.result().plans, 2);
  EXPECT_THAT(states_of(deciding), ElementsAre("look", "decide", "approach", "grasp", "lift",
                                               "carry", "put_down", "release", "leave", "success"));
}

// Whatever the plan advises, once; without a way to it, at once as it was planned.
TEST_F(LooksOfTheGripper, ViewsWhatItThenPicks) {
  ArmCycleOptions options = doing(task_named("look_and_pick"));
  options.look_timeout = 5;
  for (const bool has_look : {true, false}) {
    SCOPED_TRACE(has_look);
    ArmCycle cycle_of{options, arm, hand};
    Advice advice{Advice::Act::kGrasp, 0, "grasp it now"};
    if (has_look) advice.look = look_aside(grasp_at(0)).look;
    cycle_of.start({grasp_at(0)}, "", advice);
    if (has_look) {
      run_until_it_looks(cycle_of);
      cycle_of.take_plan({from_aside(grasp_at(0))}, "", advice);
    }
    run_to_the_end(cycle_of);
    EXPECT_TRUE(cycle_of.result().success()) << cycle_of.result().reason;
    EXPECT_EQ(cycle_of.result().looks, has_look ? 1 : 0);
    EXPECT_EQ(cycle_of.result().attempts, 1);
    EXPECT_THAT(states_of(cycle_of),
                ElementsAre("look", "view", "approach", "grasp", "lift", "carry", "put_down",
                            "release", "leave", "success"));
  }
}

// No plan, no camera that gets there, or nobody who would plan anew: what was planned is grasped.
TEST_F(LooksOfTheGripper, ALookThatFailsIsNoReasonToLeaveIt) {
  ArmCycle without_plan{deciding_with_looks(), arm, hand};
  without_plan.start({grasp_at(0)}, "", look_aside(grasp_at(0)));
  run_to_the_end(without_plan);
  EXPECT_TRUE(without_plan.result().success()) << without_plan.result().reason;
  EXPECT_EQ(without_plan.result().looks, 1);
  EXPECT_EQ(without_plan.result().plans, 1);

  ArmCycle stuck{[] {
                   ArmCycleOptions options = deciding_with_looks();
                   options.motion_timeout = 20;
                   return options;
                 }(),
                 arm, hand};
  stuck.start({grasp_at(0)}, "", look_aside(grasp_at(0)));
  for (int i = 0; i < 60000 && !stuck.finished(); ++i) {
    world.arm_stuck = stuck.detail().find("bringing the camera to") == 0;
    step(stuck);
  }
  EXPECT_TRUE(stuck.result().success()) << stuck.result().reason;
  EXPECT_EQ(stuck.result().attempts, 1);

  ArmCycleOptions unasked = deciding_with_looks();
  unasked.look_timeout = 0;
  ArmCycle nobody{unasked, arm, hand};
  nobody.start({grasp_at(0)}, "", look_aside(grasp_at(0)));
  run_to_the_end(nobody);
  EXPECT_TRUE(nobody.result().success()) << nobody.result().reason;
  EXPECT_EQ(nobody.result().looks, 0);
}

// A look that shows that nothing can be grasped: the plan before is tried, as after a touch.
TEST_F(LooksOfTheGripper, AfterALookThatGivesNoGraspItIsBackBeforeItGoesOn) {
  ArmCycleOptions options = deciding_with_looks();
  options.only_seen_again = true;
  ArmCycle deciding{options, arm, hand};
  const Eigen::Vector3d start = world.p_WG();
  deciding.start({grasp_at(0)}, "", look_aside(grasp_at(0)));
  run_until_it_looks(deciding);
  deciding.take_plan({}, "it is too wide now");
  run_to_the_end(deciding);
  EXPECT_FALSE(deciding.result().success());
  EXPECT_THAT(deciding.result().reason, HasSubstr("it is too wide now"));
  EXPECT_TRUE(world.p_WG().isApprox(start, 1e-6)) << "not where it looked from";
}

}  // namespace
}  // namespace prehend::control
