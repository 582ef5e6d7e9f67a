// What the pads foretell of a lift, and what the cycle does of it: the PG70 on its stage,
// simulated.

#include "prehend/control/grip_judge.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "prehend/control/stage_in_world.h"
#include "prehend/simulation/shapes.h"
#include "tests/control/pick_of.h"

namespace prehend::control {
namespace {

using touch::GraspStability;
using touch::GripMoment;

/// Of one feature alone, at its value `middle` a half.
GraspStability::Weighed of_one(GripMoment moment, const std::string& feature, double weight,
                               double middle) {
  const auto& names = touch::grip_feature_names(moment);
  const auto size = static_cast<Eigen::Index>(names.size());
  GraspStability::Weighed model{Eigen::VectorXd::Zero(size), Eigen::VectorXd::Ones(size),
                                Eigen::VectorXd::Zero(size), 0};
  const auto at = std::find(names.begin(), names.end(), feature) - names.begin();
  model.weight[at] = weight;
  model.mean[at] = middle;
  return model;
}

GraspStability::Weighed always(GripMoment moment, double probability) {
  GraspStability::Weighed model = of_one(moment, "pads", 0, 0);
  model.bias = std::log(probability / (1 - probability));
  return model;
}

class JudgedCycle : public testing::Test {
 protected:
  struct Picked {
    CycleResult result;
    double highest = 0;    // m, of the thing
    double strongest = 0;  // N, of the pads' mean sum
  };

  Picked pick(double minimum, const std::optional<GraspStability>& model, int attempts = 1) {
    simulation::Scene scene;
    scene.gripper = *planned.platform().hand.gripper;
    scene.start_opening = scene.gripper.max_opening;
    scene.carrier = simulation::carrier_of(planned.platform(), "side");
    simulation::World world(scene);
    const geometry::TriangleMesh box_W = simulation::make_standing_box({0.04, 0.05, 0.12});
    world.add_object("thing", box_W, 0.2);
    StageInWorld stage(world, planned.platform(), "side");
    ArmCycleOptions options = reacting();
    options.minimum_stability = minimum;
    options.largest_attempts = attempts;
    CycleInWorld cycle(stage, options);
    if (model) cycle.judge_grips(GripJudge(planned.platform(), *model));
    Picked picked;
    picked.result = cycle.run(planned.to_try(planned.plan(box_W)), nullptr, [&] {
      picked.highest = std::max(picked.highest, world.body("thing").height);
      const ArmPercepts felt = stage.percepts(10);
      picked.strongest = std::max(picked.strongest, (felt.pads[0].sum + felt.pads[1].sum) / 2);
    });
    return picked;
  }

  const PickOf planned{"stage_pg70"};
};

bool says(const CycleResult& result, const std::string& words) {
  return result.reason.find(words) != std::string::npos;
}

TEST_F(JudgedCycle, SaysWhatWasForetoldAndChangesNothingWhenOff) {
  const Picked picked = pick(
      0, GraspStability(always(GripMoment::kClosed, 0.01), always(GripMoment::kLifting, 0.03)));
  EXPECT_TRUE(picked.result.success()) << picked.result.reason;
  EXPECT_TRUE(says(picked.result, "foretold with 3 %")) << picked.result.reason;
}

TEST_F(JudgedCycle, LetsGoBeforeTheLiftOfWhatWillNotHold) {
  const Picked picked = pick(
      0.5, GraspStability(always(GripMoment::kClosed, 0.2), always(GripMoment::kLifting, 0.99)), 2);
  EXPECT_FALSE(picked.result.success());
  EXPECT_TRUE(says(picked.result, "foretell that the lift holds with 20 %, less than 50 %"))
      << picked.result.reason;
  EXPECT_LT(picked.highest, 0.005);
  EXPECT_EQ(picked.result.attempts, 2) << "another grasp is tried, as after other failures";
}

TEST_F(JudgedCycle, LetsGoSoonOfWhatSlides) {
  const Picked picked = pick(
      0.5, GraspStability(always(GripMoment::kClosed, 0.9), always(GripMoment::kLifting, 0.1)));
  EXPECT_FALSE(picked.result.success());
  EXPECT_TRUE(says(picked.result, "given up after 10 mm")) << picked.result.reason;
  EXPECT_GT(picked.highest, 0.005);
  EXPECT_LT(picked.highest, 0.04) << "it was to go up by 150 mm";
}

// Half is foretold at the force that the planned one overshoots to, which it does not keep.
TEST_F(JudgedCycle, PressesHarderWhereThatHelps) {
  const Picked planned_force = pick(0, std::nullopt);
  ASSERT_TRUE(planned_force.result.success()) << planned_force.result.reason;
  const double at = std::log(2 * planned_force.strongest);
  const Picked picked = pick(0.5, GraspStability(of_one(GripMoment::kClosed, "log_force", 20, at),
                                                 always(GripMoment::kLifting, 0.99)));
  EXPECT_TRUE(picked.result.success()) << picked.result.reason;
  EXPECT_EQ(picked.result.attempts, 1);
  EXPECT_GT(picked.strongest, 1.1 * planned_force.strongest);
}

TEST_F(JudgedCycle, TheShippedModelTrustsAGoodGrip) {
  const Picked picked = pick(0.1, GraspStability::load("config/touch/grasp_stability.yaml"));
  EXPECT_TRUE(picked.result.success()) << picked.result.reason;
  EXPECT_TRUE(says(picked.result, "foretold with")) << picked.result.reason;
}

TEST_F(JudgedCycle, RefusesAMinimumThatNothingTells) {
  EXPECT_THROW(pick(0.5, std::nullopt), std::invalid_argument);
}

TEST(GripJudge, IsNoneOfAHandThatFeelsNothing) {
  robot::Platform platform = robot::read_platform("config/robots/kr5_sdh.yaml");
  platform.hand.pads.clear();
  EXPECT_FALSE(GripJudge::of(platform));
}

// No touch: nothing is said, as the palm of a BarrettHand may hold what its pads do not meet.
TEST(GripJudge, SaysNothingWhereNoPadTouches) {
  const robot::Platform platform = robot::read_platform("config/robots/stage_pg70.yaml");
  GripJudge judge(platform, GraspStability(always(GripMoment::kClosed, 0.5),
                                           always(GripMoment::kLifting, 0.5)));
  ArmPercepts percepts;
  EXPECT_FALSE(judge.closed(percepts, {"hand_opening"}, {0.02}));
  EXPECT_FALSE(judge.lifting(percepts, {"hand_opening"}, {0.02}));
}

}  // namespace
}  // namespace prehend::control
