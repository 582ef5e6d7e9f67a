#include "nodes/grasp_planning/made_pushes.h"

#include <gtest/gtest.h>

#include "msgs/convert/geometry.h"

namespace prehend::nodes {
namespace {

msgs::GraspPlan plan_of(std::uint32_t object, double x, bool has_way = true,
                        std::int64_t view = 100) {
  msgs::GraspPlan plan;
  plan.mutable_header()->set_stamp(view);
  plan.set_id(object);
  msgs::Grasp& push = *plan.mutable_push();
  *push.mutable_x_wg() =
      convert::to_message(geometry::make_transform(Eigen::Quaterniond::Identity(), {x, 0.2, 0.05}));
  *push.mutable_approach_direction() = convert::to_message(Eigen::Vector3d(0, 1, 0));
  if (has_way) push.add_arm();
  return plan;
}

msgs::CycleState state_of(msgs::CycleState::Phase phase, std::uint32_t object,
                          std::int64_t view = 100) {
  msgs::CycleState state;
  state.set_view_stamp(view);
  state.set_phase(phase);
  state.set_object_id(object);
  return state;
}

TEST(MadePushes, AreThoseThatBegan) {
  MadePushes pushes;
  pushes.begun(state_of(msgs::CycleState::PUSH, 1));
  pushes.planned(plan_of(0, 0.1));
  pushes.planned(plan_of(1, 0.3));
  pushes.planned(plan_of(2, 0.5, false));
  pushes.begun(state_of(msgs::CycleState::APPROACH, 0));
  pushes.begun(state_of(msgs::CycleState::PUSH, 2));
  EXPECT_TRUE(pushes.lines().empty());
  for (int step = 0; step < 3; ++step) pushes.begun(state_of(msgs::CycleState::PUSH, 1));
  ASSERT_EQ(pushes.lines().size(), 1u) << "the steps of one push";
  EXPECT_TRUE(pushes.lines()[0].end_W.isApprox(Eigen::Vector3d(0.3, 0.2, 0.05)));
  EXPECT_TRUE(pushes.lines()[0].direction_W.isApprox(Eigen::Vector3d(0, 1, 0)));
  // Of the next look.
  pushes.planned(plan_of(1, 0.4));
  pushes.begun(state_of(msgs::CycleState::PUSH, 1));
  EXPECT_EQ(pushes.lines().size(), 2u);
  pushes.clear();
  EXPECT_TRUE(pushes.lines().empty());
  pushes.begun(state_of(msgs::CycleState::PUSH, 0));
  EXPECT_TRUE(pushes.lines().empty()) << "of another cycle";
}

TEST(MadePushes, AreForgottenWhenSomethingWasTakenFromThere) {
  MadePushes pushes;
  pushes.planned(plan_of(0, 0.1));
  pushes.planned(plan_of(1, 0.3));
  pushes.begun(state_of(msgs::CycleState::PUSH, 0));
  ASSERT_EQ(pushes.lines().size(), 1u);
  pushes.something_was_put_down();
  EXPECT_TRUE(pushes.lines().empty());
  pushes.begun(state_of(msgs::CycleState::PUSH, 1));
  EXPECT_EQ(pushes.lines().size(), 1u) << "planned before it was put down, begun after";
}

// Regression: cameras go on while something is pushed, and in a newer view another object has its
// id.
TEST(MadePushes, AreOfTheViewThatTheRobotMovesBy) {
  MadePushes pushes;
  pushes.planned(plan_of(1, 0.3));
  pushes.planned(plan_of(1, 0.6, true, 200));
  for (int step = 0; step < 3; ++step) pushes.begun(state_of(msgs::CycleState::PUSH, 1));
  pushes.planned(plan_of(1, 0.9, true, 300));
  pushes.begun(state_of(msgs::CycleState::PUSH, 1));
  ASSERT_EQ(pushes.lines().size(), 1u);
  EXPECT_NEAR(pushes.lines()[0].end_W.x(), 0.3, 1e-6);
  pushes.begun(state_of(msgs::CycleState::PUSH, 1, 300));
  ASSERT_EQ(pushes.lines().size(), 2u);
  EXPECT_NEAR(pushes.lines()[1].end_W.x(), 0.9, 1e-6);
  for (int i = 0; i < 400; ++i) pushes.planned(plan_of(0, 0.1, true, 400 + i));
  pushes.begun(state_of(msgs::CycleState::PUSH, 0, 400));
  EXPECT_EQ(pushes.lines().size(), 2u) << "too old";
}

}  // namespace
}  // namespace prehend::nodes
