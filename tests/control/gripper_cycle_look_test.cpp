// After a failed attempt: what is seen then, and which grasp is tried next.

#include <numbers>

#include "prehend/control/grasp_order.h"
#include "tests/control/gripper_cycle_fixture.h"

namespace prehend::control {
namespace {

// The cycle that looks again, for at most 5 s.
class LookingCycleTest : public GripperCycleTest {
 protected:
  static ArmCycleOptions options() {
    ArmCycleOptions o = reacting();
    o.look_timeout = 5;
    return o;
  }
  void run_until_it_looks(ArmCycle* driven) {
    for (int i = 0; i < 20000 && !driven->finished() && !driven->looks_since(); ++i) {
      driven->step(world.percepts());
      world.advance();
    }
    ASSERT_TRUE(driven->looks_since()) << driven->detail();
  }
  void run_to_the_end(ArmCycle* driven) {
    for (int i = 0; i < 20000 && !driven->finished(); ++i) {
      driven->step(world.percepts());
      world.advance();
    }
    ASSERT_TRUE(driven->finished()) << driven->detail();
  }
  ArmCycle looking{options(), arm, hand};
};

// Once the second attempt closed on nothing too: the first one had pushed the object aside.
TEST_F(LookingCycleTest, TakesAPlanOfWhereTheObjectIsNow) {
  world.object_is_anywhere = false;
  world.object_x = 0.06;
  const Eigen::Vector3d start = world.p_WG();
  looking.start({grasp_at(0), grasp_at(0.01), grasp_at(-0.01)});
  run_until_it_looks(&looking);
  EXPECT_TRUE(world.p_WG().isApprox(start, 1e-6)) << "it stands in the camera's view";
  EXPECT_NEAR(*looking.looks_since(), world.percepts().time, 0.05);
  looking.take_plan({grasp_at(0.06, {0.1, 0, 0})});
  EXPECT_FALSE(looking.looks_since());
  run_to_the_end(&looking);
  EXPECT_TRUE(looking.result().success()) << looking.result().reason;
  EXPECT_EQ(looking.result().attempts, 2);
  EXPECT_EQ(looking.result().plans, 2);
  EXPECT_EQ(looking.result().grasp_index, 0);
  EXPECT_NEAR(world.p_WG().x(), 0.16, 1e-6) << "not carried by the new plan's way";
}

TEST_F(LookingCycleTest, WithoutANewPlanTakesTheNextGrasp) {
  world.object_is_anywhere = false;
  world.object_x = 0.05;
  looking.start({grasp_at(0), grasp_at(0.002), grasp_at(0.05)});
  run_until_it_looks(&looking);
  const double since = *looking.looks_since();
  bool said = false;
  for (int i = 0; i < 20000 && !looking.finished(); ++i) {
    looking.step(world.percepts());
    said = said || looking.detail().find("no new plan came") != std::string::npos;
    if (!looking.looks_since()) break;
    world.advance();
  }
  EXPECT_NEAR(world.percepts().time - since, options().look_timeout, 0.05);
  EXPECT_TRUE(said);
  run_to_the_end(&looking);
  EXPECT_TRUE(looking.result().success()) << looking.result().reason;
  EXPECT_EQ(looking.result().grasp_index, 2) << "2 mm beside the one that failed";
  EXPECT_EQ(looking.result().plans, 1);
}

TEST_F(LookingCycleTest, AnEmptyNewPlanIsSaidAndTheOldOneGoesOn) {
  world.object_width = 0;
  looking.start({grasp_at(0)});
  run_until_it_looks(&looking);
  looking.take_plan({}, "cannot be grasped: too wide");
  EXPECT_TRUE(looking.finished());
  EXPECT_NE(looking.result().reason.find("too wide"), std::string::npos) << looking.result().reason;
}

// In a replay the next grasp of the plan closed where the object had been.
TEST_F(LookingCycleTest, EndsWithoutANewPlanWhenOnlyThatWillDo) {
  ArmCycleOptions only = options();
  only.only_seen_again = true;
  ArmCycle strict{only, arm, hand};
  world.object_width = 0;
  strict.start({grasp_at(0), grasp_at(0.05)});
  run_until_it_looks(&strict);
  strict.take_plan({}, "the object has tipped by 90 deg");
  EXPECT_TRUE(strict.finished());
  EXPECT_EQ(strict.result().attempts, 1);
  EXPECT_NE(strict.result().reason.find("tipped by 90 deg"), std::string::npos)
      << strict.result().reason;
  ArmCycle waiting{only, arm, hand};
  waiting.start({grasp_at(0), grasp_at(0.05)});
  run_to_the_end(&waiting);
  EXPECT_EQ(waiting.result().attempts, 1);
  EXPECT_NE(waiting.result().reason.find("no new plan came"), std::string::npos)
      << waiting.result().reason;
}

TEST_F(LookingCycleTest, WhatFailedIsTriedLastThoughItIsPlannedAgain) {
  world.object_is_anywhere = false;
  world.object_x = 0.04;
  looking.start({grasp_at(0)});
  run_until_it_looks(&looking);
  looking.take_plan({grasp_at(0.003), grasp_at(0.04)});
  run_to_the_end(&looking);
  EXPECT_TRUE(looking.result().success()) << looking.result().reason;
  EXPECT_EQ(looking.result().attempts, 2);
  EXPECT_EQ(looking.result().grasp_index, 1);
}

TEST_F(LookingCycleTest, GivesUpAfterTheLastAttemptWithoutLooking) {
  world.object_width = 0;
  looking.start({grasp_at(0)});
  for (int attempt = 1; attempt < options().largest_attempts; ++attempt) {
    run_until_it_looks(&looking);
    looking.take_plan({grasp_at(0.05 * attempt)});
  }
  run_to_the_end(&looking);
  EXPECT_FALSE(looking.result().success());
  EXPECT_EQ(looking.result().attempts, options().largest_attempts);
  looking.take_plan({grasp_at(0)});
  EXPECT_TRUE(looking.finished()) << "a plan that nobody waits for";
}

GraspPose pose_at(double x) { return {grasp_at(x).pose.X_WG, ""}; }

TEST(GraspOrder, LikeIsWithinMillimetresAndTurnedByHalf) {
  const GraspPose grasp = pose_at(0);
  EXPECT_TRUE(is_like(grasp, pose_at(0.005)));
  EXPECT_FALSE(is_like(grasp, pose_at(0.007)));
  GraspPose turned = grasp;
  turned.X_WG.rotate(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(is_like(grasp, turned));
  GraspPose fingers = grasp, turned_fingers = turned;
  fingers.preshape = turned_fingers.preshape = "parallel";
  EXPECT_TRUE(is_like(fingers, fingers));
  EXPECT_FALSE(is_like(fingers, turned_fingers)) << "three fingers, turned by half";
  EXPECT_FALSE(is_like(fingers, grasp));
  turned.X_WG.rotate(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()));
  EXPECT_FALSE(is_like(grasp, turned));
  turned = grasp;
  turned.X_WG.rotate(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()));
  EXPECT_FALSE(is_like(grasp, turned));
}

TEST(GraspOrder, WhatFailedComesLastInThisPlanAndTheNext) {
  GraspOrder order;
  EXPECT_EQ(order.next(), std::nullopt);
  order.start({pose_at(0), pose_at(0.002), pose_at(0.05)});
  EXPECT_EQ(order.next(), 0);
  order.begin(0);
  order.fail(0);
  EXPECT_EQ(order.next(), 2) << "1 is like the one that failed";
  order.begin(2);
  EXPECT_EQ(order.next(), 1);
  order.begin(1);
  EXPECT_EQ(order.next(), std::nullopt);
  order.take({pose_at(0.001), pose_at(0.1)});
  EXPECT_EQ(order.next(), 1);
  order.start({pose_at(0.001), pose_at(0.1)});
  EXPECT_EQ(order.next(), 0) << "another object";
}

TEST(GraspOrder, WhatIsPreferredComesFirstOnce) {
  GraspOrder order;
  order.start({pose_at(0), pose_at(0.05), pose_at(0.1)});
  EXPECT_THROW(order.prefer(3), std::out_of_range);
  order.prefer(2);
  EXPECT_EQ(order.next(), 2);
  order.begin(2);
  order.fail(2);
  EXPECT_EQ(order.next(), 0);
  order.take({pose_at(0), pose_at(0.05)});
  EXPECT_EQ(order.next(), 0) << "it was of the plan before";
}

// What a user has chosen goes before what the plan thinks best, and before what it would feel
// first.
TEST_F(LookingCycleTest, BeginsWithTheGraspThatWasChosen) {
  Advice chosen;
  chosen.first = 1;
  looking.start({grasp_at(0.01), grasp_at(0)}, "", chosen);
  run_to_the_end(&looking);
  EXPECT_TRUE(looking.result().success()) << looking.result().reason;
  EXPECT_EQ(looking.result().grasp_index, 1);
  EXPECT_EQ(looking.result().attempts, 1);
}

}  // namespace
}  // namespace prehend::control
