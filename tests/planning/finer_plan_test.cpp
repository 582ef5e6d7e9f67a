// Where hand and arm can execute no grasp of the usual candidates, finer ones are tried once.

#include <gmock/gmock.h>

#include "prehend/planning/platform_plan.h"
#include "prehend/robot/robot_files.h"
#include "prehend/surface/model.h"

namespace prehend::planning {
namespace {

class FinerPlan : public ::testing::Test {
 protected:
  /// So few candidates that all of them hold a ball above its middle, from where it slides.
  PlatformPlanOptions few(int finer) const {
    PlatformPlanOptions options(planner_.platform().hand);
    grasp::GeneratorOptions& candidates = options.grasps.candidates;
    candidates.samples = candidates.approaches = candidates.rolls = candidates.standoffs = 1;
    candidates.circles.directions_per_circle = candidates.circles.rolls = 1;
    candidates.circles.standoffs = 1;
    candidates.circles.lateral_offsets = {0};
    options.grasps.generators = {"circles"};
    options.remedies.budget = 0;
    options.finer = finer;
    return options;
  }
  /// @param height m, of the mesh's middle.
  PlatformPlan plan(const geometry::TriangleMesh& mesh, double height,
                    const PlatformPlanOptions& options) const {
    geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();
    X_WB.translation().z() = height;
    return planner_.plan(surface::model_of_mesh(geometry::transformed(mesh, X_WB)),
                         geometry::Plane{}, {}, {}, planner_.platform().home("home").arm, options);
  }
  PlatformPlan plan(const Eigen::Vector3d& size, const PlatformPlanOptions& options) const {
    return plan(geometry::make_box(size), size.z() / 2, options);
  }
  const PlatformPlanner planner_{robot::read_platform("config/robots/stage_pg70.yaml")};
};

TEST_F(FinerPlan, FindsWhatFewCandidatesDoNot) {
  const geometry::TriangleMesh ball = geometry::make_sphere(0.03, 4);
  const PlatformPlan few_tried = plan(ball, 0.03, few(1));
  ASSERT_TRUE(few_tried.picks.empty()) << "the test's few candidates are to have no grasp";
  const PlatformPlan more = plan(ball, 0.03, few(8));
  EXPECT_FALSE(more.picks.empty()) << more.problem;
  EXPECT_GT(more.candidates, 8 * few_tried.candidates);
  EXPECT_EQ(more.outcome, grasp::PlanOutcome::kGraspable);
}

// What is too wide stays so, and what there is a grasp of is planned as it was.
TEST_F(FinerPlan, IsTriedOnlyWhereItMayHelp) {
  const Eigen::Vector3d too_wide(0.2, 0.2, 0.1);
  PlatformPlanOptions usual(planner_.platform().hand);
  usual.remedies.budget = 0;
  for (const Eigen::Vector3d& size : {too_wide, Eigen::Vector3d(0.05, 0.07, 0.12)}) {
    usual.finer = 1;
    const PlatformPlan once = plan(size, usual);
    usual.finer = 10;
    const PlatformPlan again = plan(size, usual);
    EXPECT_EQ(once.candidates, again.candidates);
    EXPECT_EQ(once.problem, again.problem);
    EXPECT_EQ(once.picks.size(), again.picks.size());
  }
}

TEST_F(FinerPlan, RefusesWhatIsNone) {
  for (const int finer : {0, -1, 11}) {
    EXPECT_THROW(plan({0.05, 0.07, 0.12}, few(finer)), std::invalid_argument) << finer;
  }
}

}  // namespace
}  // namespace prehend::planning
