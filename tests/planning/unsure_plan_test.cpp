// What is predicted as one thing and may be several is put down by what the hand holds of it.

#include <gtest/gtest.h>

#include "prehend/planning/platform_plan.h"
#include "prehend/robot/robot_files.h"
#include "prehend/surface/model.h"

namespace prehend::planning {
namespace {

using Eigen::Vector3d;

geometry::TriangleMesh box_at(const Vector3d& size, double x, double y) {
  return geometry::transformed(
      geometry::make_box(size),
      geometry::make_transform(Eigen::Quaterniond::Identity(), {x, y, 0.5 * size.z()}));
}

class UnsurePlan : public ::testing::Test {
 protected:
  // Of two boxes with a gap the jaws do not fit in, as one object: only the smaller can be grasped.
  PlatformPlan plan(bool unsure, PlatformPlanOptions options, const Neighbours& beside = {}) const {
    options.shape_confidence = unsure ? 0.3 : 0.6;
    options.arm.pick.budget = 0;
    options.remedies.budget = 0;
    const std::vector<geometry::TriangleMesh> boxes{box_at({0.05, 0.09, 0.12}, 0.09, 0),
                                                    box_at({0.12, 0.12, 0.08}, 0, 0)};
    surface::ObjectModel object = surface::model_of_mesh(geometry::concatenated(boxes));
    object.convex_pieces_W = boxes;
    return planner_.plan(object, {}, beside, {}, start(), options);
  }
  PlatformPlanOptions in_region() const {
    PlatformPlanOptions options(planner_.platform().hand);
    options.place.region_W.emplace();
    options.place.region_W->name = "beside";
    options.place.region_W->center = {0, 0.35};
    options.place.region_W->size = {0.3, 0.1};
    return options;
  }
  robot::Positions start() const { return planner_.platform().home("home").arm; }
  const PlatformPlanner planner_{robot::read_platform("config/robots/stage_pg70.yaml")};
};

// Regression: three of three things that a table was not cleared of had been put down beside the
// place, by the middle of several.
TEST_F(UnsurePlan, WhatIsHeldIsPutInThePlace) {
  PlatformPlanOptions options = in_region();
  options.place.region_W->size = {0.02, 0.02};  // the middle only
  for (const bool unsure : {false, true}) {
    const PlatformPlan plan = this->plan(unsure, options);
    ASSERT_FALSE(plan.picks.empty()) << plan.problem;
    int moved = 0;
    for (const PlannedPick& pick : plan.picks) {
      if (pick.segments.empty()) continue;
      ++moved;
      ASSERT_TRUE(pick.move_W.has_value());
      const Eigen::Vector2d hand = (pick.grasp.X_WG.translation() + *pick.move_W).head<2>();
      const double beside = (hand - options.place.region_W->center).norm();
      if (unsure) {
        EXPECT_LT(beside, 0.021) << "as near as grasps are taken for the same";
      } else {
        EXPECT_GT(beside, 0.03) << "the middle of both is put there";
      }
    }
    EXPECT_GT(moved, 0);
  }
}

TEST_F(UnsurePlan, WithoutAPlaceItIsPutWhereThereIsRoom) {
  const PlatformPlan sure = plan(false, PlatformPlanOptions(planner_.platform().hand)),
                     unsure = plan(true, PlatformPlanOptions(planner_.platform().hand));
  ASSERT_FALSE(unsure.picks.empty()) << unsure.problem;
  ASSERT_EQ(sure.picks.size(), unsure.picks.size());
  EXPECT_EQ(*sure.picks.front().move_W, *unsure.picks.front().move_W);
}

TEST_F(UnsurePlan, AFullPlaceIsSaid) {
  Neighbours beside;
  beside.meshes_W = beside.pieces_W = {box_at({0.5, 0.4, 0.1}, 0, 0.35)};
  for (const bool unsure : {false, true}) {
    const PlatformPlan plan = this->plan(unsure, in_region(), beside);
    EXPECT_EQ(plan.outcome, grasp::PlanOutcome::kUngraspable);
    EXPECT_NE(plan.problem.find("the place 'beside'"), std::string::npos) << plan.problem;
    EXPECT_NE(plan.problem.find(kPlaceMend), std::string::npos) << plan.problem;
  }
}

}  // namespace
}  // namespace prehend::planning
