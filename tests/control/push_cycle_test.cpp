// Pushes by the shipped cycle: of a thing that stands in the world, and in a task.

#include <string>

#include <gmock/gmock.h>

#include "prehend/control/arm_in_world.h"
#include "prehend/simulation/shapes.h"
#include "tests/control/pick_of.h"

namespace prehend::control {
namespace {

constexpr const char* kPushing = R"(start: look
states:
  look: {do: look, done: leave, nothing: push, failed: failure}
  push: {do: push, done: back, nothing: success, failed: let_go}
  let_go: {do: release, done: back, failed: failure}
  back: {do: retreat, done: look, failed: failure}
  leave: {do: approach, done: back, failed: let_go}
)";

class PushOfBox : public testing::TestWithParam<const char*> {};

TEST_P(PushOfBox, MovesItAndGoesBack) {
  const PickOf planned(GetParam());
  const geometry::TriangleMesh mesh_W = simulation::make_standing_box({0.09, 0.09, 0.06});
  simulation::Scene scene;
  scene.wrench.emplace();
  simulation::RobotWorld world(planned.platform(), scene, "side");
  world.add_object("thing", mesh_W, 0.4);
  planning::PlatformPlanOptions options = planned.plan_options();
  options.push.emplace();
  const surface::ObjectModel object = surface::model_of_mesh(mesh_W);
  const planning::PlannedPush push = planning::plan_push(
      planned.platform(), grasp::HandToClose(planned.platform().hand), planned.start, object,
      {geometry::Plane(), object.convex_pieces_W, {}}, options.arm, *options.push);
  const std::optional<ArmGrasp> pushing = arm_push(planned.platform(), push);
  ASSERT_TRUE(pushing) << push.problem;
  ArmCycleOptions cycle = reacting();
  cycle.task = parse_task(kPushing, "pushing.yaml");
  cycle.largest_pushes = 1;
  ArmInWorld arm(world);
  CycleInWorld in_world(arm, cycle);
  const CycleResult& result = in_world.run({{*pushing}, "it cannot be grasped"});
  EXPECT_TRUE(result.success()) << result.reason;
  EXPECT_THAT(result.reason, testing::HasSubstr("largest_pushes"));
  EXPECT_EQ(result.pushes, 1);
  EXPECT_EQ(result.tries(), 0);
  const Eigen::Vector3d moved = world.body("thing").X_WB.translation();
  EXPECT_GT(moved.dot(push.hand.approach_W), 0.3 * push.length) << "fingers give";
  EXPECT_LT(moved.dot(push.hand.approach_W), push.length + 0.02);
  EXPECT_NEAR(world.body("thing").X_WB.linear()(2, 2), 1, 0.01) << "it stands";
}

INSTANTIATE_TEST_SUITE_P(Platforms, PushOfBox,
                         testing::Values("stage_pg70", "kr5_sdh", "pa10_barrett"));

}  // namespace
}  // namespace prehend::control
