// Every platform finds a way to push a box along the table, by its model alone.

#include "prehend/planning/push_plan.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <gmock/gmock.h>

#include "prehend/geometry/mesh_query.h"
#include "prehend/planning/platform_plan.h"
#include "prehend/robot/platform.h"
#include "prehend/surface/model.h"

namespace prehend::planning {
namespace {

using Eigen::Vector3d;

surface::ObjectModel box_at(double x, double y, const Vector3d& size) {
  return surface::model_of_mesh(geometry::transformed(
      geometry::make_box(size),
      geometry::make_transform(Eigen::Quaterniond::Identity(), {x, y, 0.5 * size.z()})));
}

class PushPlan : public testing::TestWithParam<const char*> {
 protected:
  PlannedPush plan(const std::vector<surface::ObjectModel>& beside = {},
                   const PushPlanOptions& options = {}) const {
    PlatformPickOptions arm;
    arm.pick.budget = 0;
    const surface::ObjectModel object = box();
    PlatformScene scene{geometry::Plane(), object.convex_pieces_W, {}};
    for (const surface::ObjectModel& one : beside) {
      scene.obstacle_pieces_W.insert(scene.obstacle_pieces_W.end(), one.convex_pieces_W.begin(),
                                     one.convex_pieces_W.end());
    }
    return plan_push(platform_, grasp::HandToClose(platform_.hand), platform_.home("side").arm,
                     object, scene, arm, options);
  }
  static surface::ObjectModel box() { return box_at(0, 0, {0.09, 0.09, 0.08}); }

  Vector3d tool_at(const motion::BlendedTrajectory& way, double share) const {
    const robot::KinematicChain chain = platform_.arm_chain();
    const robot::Preshape& preshape = platform_.hand.preshapes.front();
    return (platform_.X_WB * chain.forward(way.at(share * way.duration()).position) *
            platform_.X_FH * platform_.hand.X_HP * preshape.X_PG)
        .translation();
  }

  const robot::Platform platform_ =
      robot::read_platform(std::string("config/robots/") + GetParam() + ".yaml");
};

TEST_P(PushPlan, GoesStraightAlongTheTableThroughIt) {
  const PlannedPush push = plan();
  ASSERT_EQ(push.segments.size(), 2u) << push.problem;
  EXPECT_EQ(push.segments[0].kind, motion::SegmentKind::kReach);
  EXPECT_EQ(push.segments[1].kind, motion::SegmentKind::kApproach);
  EXPECT_EQ(push.room, push.length) << "nothing is in the way";
  const Vector3d d_W = push.hand.approach_W;
  EXPECT_NEAR(d_W.z(), 0, 1e-9);
  const motion::BlendedTrajectory& way = *push.segments[1].trajectory;
  const Vector3d begin = tool_at(way, 0);
  for (const double share : {0.25, 0.5, 0.75, 1.0}) {
    const Vector3d gone = tool_at(way, share) - begin;
    EXPECT_LT((gone - gone.dot(d_W) * d_W).norm(), 0.002) << "beside the line, at " << share;
  }
  EXPECT_NEAR((tool_at(way, 1) - begin).norm(), push.hand.pregrasp_distance, 0.002);
  EXPECT_GT(push.hand.pregrasp_distance, push.length) << "it begins clear of the box";
}

// With a wall on one side, it is not pushed there.
TEST_P(PushPlan, PushesWhereThereIsRoom) {
  const PlannedPush push = plan({box_at(0, 0.08, {0.15, 0.02, 0.04})});
  ASSERT_FALSE(push.segments.empty()) << push.problem;
  EXPECT_EQ(push.room, push.length);
  EXPECT_LT(push.hand.approach_W.y(), 0.5);
}

// What did not part things once would not do so again.
TEST_P(PushPlan, ComesFromAnotherSideThanBefore) {
  PushPlanOptions options;
  std::vector<PushLine>& made = options.made;
  for (int i = 0; i < 3; ++i) {
    const PlannedPush push = plan({}, options);
    ASSERT_FALSE(push.segments.empty()) << push.problem;
    const PushLine line{push.hand.X_WG.translation(), push.hand.approach_W};
    for (const PushLine& before : made) {
      const bool is_beside = (before.end_W - line.end_W).norm() > 0.1;
      EXPECT_TRUE(is_beside || before.direction_W.dot(line.direction_W) < 0.71) << i;
    }
    made.push_back(line);
  }
  options.made = {{Vector3d::Zero(), Vector3d::Zero()}};
  EXPECT_THROW(plan({}, options), std::invalid_argument);
}

TEST_P(PushPlan, SaysWhyThereIsNone) {
  std::vector<surface::ObjectModel> ring;
  for (const double side : {-1.0, 1.0}) {
    ring.push_back(box_at(0, side * 0.065, {0.4, 0.03, 0.3}));
    ring.push_back(box_at(side * 0.065, 0, {0.03, 0.4, 0.3}));
  }
  const PlannedPush push = plan(ring);
  EXPECT_TRUE(push.segments.empty());
  EXPECT_NE(push.problem, "");
  const PlannedPush of_nothing =
      plan_push(platform_, grasp::HandToClose(platform_.hand), platform_.home("side").arm, box(),
                {geometry::Plane(), {}, {}}, {});
  EXPECT_TRUE(of_nothing.segments.empty());
  EXPECT_NE(of_nothing.problem, "");
}

TEST_P(PushPlan, RefusesOptionsOutOfRange) {
  for (double PushPlanOptions::*const field :
       {&PushPlanOptions::speed, &PushPlanOptions::beyond, &PushPlanOptions::height}) {
    for (const double bad : {0.0, -1.0, std::nan("")}) {
      PushPlanOptions options;
      options.*field = bad;
      EXPECT_THROW(plan({}, options), std::invalid_argument);
    }
  }
  PushPlanOptions options;
  options.directions = 0;
  EXPECT_THROW(plan({}, options), std::invalid_argument);
}

// A cube that is too wide is one thing with room about it: to push it would change nothing.
TEST(PushOfAPlan, IsPlannedWhereItMayHelpOnly) {
  const PlatformPlanner planner(robot::read_platform("config/robots/stage_pg70.yaml"));
  const robot::Positions start = planner.platform().home("side").arm;
  std::vector<PushLine> made;
  const auto plan_of = [&](const Neighbours& neighbours, double confidence, double width) {
    PlatformPlanOptions options(planner.platform().hand);
    options.arm.pick.budget = 0;
    options.push.emplace().made = made;
    options.shape_confidence = confidence;
    return planner.plan(box_at(0, 0, {width, 0.2, 0.06}), {}, neighbours, {}, start, options);
  };
  Neighbours wall;
  for (const double side : {-1.0, 1.0}) {
    const surface::ObjectModel one = box_at(side * 0.045, 0, {0.03, 0.2, 0.06});
    wall.meshes_W.push_back(one.mesh_W);
    wall.pieces_W.push_back(one.mesh_W);
  }
  constexpr double kSure = 0.95, kFairlySure = 0.7, kUnsure = 0.3;
  EXPECT_TRUE(plan_of({}, kSure, 0.15).push.segments.empty());
  const PlatformPlan unsure = plan_of({}, kUnsure, 0.15);
  EXPECT_FALSE(unsure.push.segments.empty());
  EXPECT_NEAR(unsure.push.worth, 0.7, 1e-9);
  // Two cans side by side look like one symmetric body: pushed once.
  const PlatformPlan fairly_sure = plan_of({}, kFairlySure, 0.15);
  EXPECT_FALSE(fairly_sure.push.segments.empty());
  EXPECT_LT(fairly_sure.push.worth, unsure.push.worth) << "what is less sure is pushed first";
  made = {{fairly_sure.push.hand.X_WG.translation(), fairly_sure.push.hand.approach_W}};
  EXPECT_TRUE(plan_of({}, kFairlySure, 0.15).push.segments.empty());
  EXPECT_FALSE(plan_of({}, kUnsure, 0.15).push.segments.empty());
  made.clear();
  const PlatformPlan between = plan_of(wall, kSure, 0.05);
  EXPECT_EQ(between.outcome, grasp::PlanOutcome::kUngraspable);
  EXPECT_FALSE(between.push.segments.empty()) << between.push.problem;
  EXPECT_TRUE(plan_of({}, kFairlySure, 0.05).push.segments.empty()) << "it can be grasped";
}

INSTANTIATE_TEST_SUITE_P(Platforms, PushPlan,
                         testing::Values("stage_pg70", "kr5_pg70", "kr5_sdh", "pa10_barrett",
                                         "panda"));

}  // namespace
}  // namespace prehend::planning
