#include "prehend/planning/platform_pick.h"

#include <gtest/gtest.h>

#include "prehend/surface/model.h"

namespace prehend::planning {
namespace {

using geometry::TriangleMesh;

const robot::Platform& stage() {
  static const robot::Platform platform = robot::read_platform("config/robots/stage_pg70.yaml");
  return platform;
}

surface::ObjectModel standing(const TriangleMesh& mesh, const Eigen::Vector3d& p_W, double yaw) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  return surface::model_of_mesh(geometry::transformed(mesh, geometry::make_transform(turn, p_W)));
}

grasp::GraspPlan plan_on_stage(const surface::ObjectModel& object,
                               const grasp::PlannerOptions& options) {
  return grasp::plan_grasps(object, geometry::Plane{}, {}, grasp::HandToClose(stage().hand),
                            within_reach(grasp::Reachability{}, stage()),
                            within_reach(options, stage()));
}

// What carries the gripper is no part of the search.
TEST(StagePlan, IsBitwiseThatOfTheGripperFromStraightAbove) {
  grasp::Reachability down;
  down.approach_W = -Eigen::Vector3d::UnitZ();
  const TriangleMesh can = geometry::make_revolution({{0.03, 0}, {0.03, 0.1}}, 48);
  const TriangleMesh ball = geometry::make_sphere(0.028, 3);
  const surface::ObjectModel objects[] = {
      standing(geometry::make_box({0.05, 0.07, 0.12}), {0.1, -0.2, 0.06}, 0.5),
      standing(can, {-0.3, 0.25, 0}, 0), standing(ball, {0, 0, 0.028}, 0)};
  for (const surface::ObjectModel& object : objects) {
    const grasp::PlannerOptions options;
    const grasp::GraspPlan direct =
        grasp::plan_grasps(object, geometry::Plane{}, {}, *stage().hand.gripper, down, options);
    const grasp::GraspPlan plan = plan_on_stage(object, options);
    ASSERT_FALSE(direct.grasps.empty()) << direct.problem;
    EXPECT_EQ(plan.candidates, direct.candidates);
    ASSERT_EQ(plan.grasps.size(), direct.grasps.size());
    for (std::size_t i = 0; i < direct.grasps.size(); ++i) {
      const grasp::Grasp& a = direct.grasps[i];
      const grasp::Grasp& b = plan.grasps[i];
      EXPECT_EQ(a.X_WG.matrix(), b.X_WG.matrix());
      EXPECT_EQ(a.approach_W, b.approach_W);
      EXPECT_EQ(a.score, b.score);
      EXPECT_EQ(a.quality, b.quality);
      EXPECT_EQ(a.robustness, b.robustness);
      EXPECT_EQ(a.force, b.force);
      EXPECT_EQ(a.predicted.opening, b.predicted.opening);
      EXPECT_EQ(a.open, b.open);
      EXPECT_EQ(contact_points(a), contact_points(b));
    }
  }
}

TEST(StagePlan, WhatIsBeyondItsWaysIsRefusedAsOutOfReach) {
  const auto box = geometry::make_box({0.05, 0.07, 0.12});
  const grasp::GraspPlan plan = plan_on_stage(standing(box, {0.75, 0, 0.06}, 0), {});
  EXPECT_TRUE(plan.grasps.empty());
  EXPECT_NE(plan.problem.find("reach"), std::string::npos) << plan.problem;
}

TEST(StagePlan, ADirectionThatIsAskedForStays) {
  grasp::Reachability aslant;
  aslant.approach_W = Eigen::Vector3d(0, 0.6, -0.8);
  EXPECT_EQ(*within_reach(aslant, stage()).approach_W, *aslant.approach_W);
}

// Regression: what holds the fingers reaches 3 mm beyond them, so of what lies low each grasp
// touched the table for the arm, and a third of the hard bodies was not picked.
TEST(StagePlan, TheArmTakesGraspsAsLowAsTheHandDoes) {
  const surface::ObjectModel flat =
      standing(geometry::make_box({0.05, 0.09, 0.022}), {0, 0, 0.011}, 0.3);
  const grasp::GraspPlan plan = plan_on_stage(flat, grasp::PlannerOptions{});
  ASSERT_FALSE(plan.grasps.empty()) << plan.problem;
  std::vector<PlatformGrasp> grasps;
  for (const grasp::Grasp& grasp : plan.grasps) grasps.push_back(to_pick(grasp));
  PlatformScene scene;
  scene.object_pieces_W = flat.convex_pieces_W;
  const robot::Positions home = stage().home("home").arm;
  int taken = 0, taken_by_balls = 0;
  for (PlatformGrasp& grasp : grasps) {
    const PlatformPick pick = plan_platform_pick(stage(), home, {grasp}, scene);
    EXPECT_EQ(pick.motion.problem.find("'table'"), std::string::npos) << pick.motion.problem;
    taken += pick.motion.found() ? 1 : 0;
    grasp.clears_table = false;  // nobody says that the hand keeps clear of it
    const PlatformPick by_balls = plan_platform_pick(stage(), home, {grasp}, scene);
    taken_by_balls += by_balls.motion.found() ? 1 : 0;
  }
  EXPECT_GT(taken, taken_by_balls);
}

}  // namespace
}  // namespace prehend::planning
