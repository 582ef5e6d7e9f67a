#include "prehend/fidelity/chain_settings.h"

#include <filesystem>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/fidelity/plan_settings.h"
#include "prehend/fidelity/shape_settings.h"
#include "prehend/planning/chain_motion.h"
#include "prehend/robot/hand_model.h"

namespace prehend::fidelity {
namespace {

using geometry::InputError;
using ::testing::AllOf;
using ::testing::HasSubstr;

Setting chain(const std::string& stereo, const std::string& spacing, const std::string& rolls,
              double seconds, double not_lifted, double mesh) {
  Setting setting;
  setting.knobs = {{"seeing.stereo", stereo}, {"shape.spacing", spacing}, {"plan.rolls", rolls}};
  setting.seconds = seconds;
  setting.error = not_lifted;
  setting.other_errors = {
      {"mesh", mesh}, {"seeing", 0.5 * seconds}, {"shape", 0.3 * seconds}, {"plan", 0.2 * seconds}};
  return setting;
}

Front three_chains() {
  Front front;
  front.subject = "chain";
  front.error_unit = "of views";
  front.settings = {chain("block_matching", "0.006", "6", 0.1, 0.3, 0.004),
                    chain("semi_global", "0.006", "8", 0.2, 0.1, 0.0025),
                    chain("semi_global", "0.004", "12", 0.4, 0.05, 0.002)};
  return front;
}

TEST(ChainSettings, EachStageTakesItsOwnKnobs) {
  const Front front = three_chains();
  const Setting& first = front.settings[0];
  SeeingOptions seeing;
  seeing.stereo.eight_directions = true;
  apply_seeing_setting(stage_setting(front, first, Stage::kSeeing), &seeing);
  EXPECT_EQ(seeing.stereo.method, perception::StereoMethod::kBlockMatching);
  EXPECT_FALSE(seeing.stereo.eight_directions);
  EXPECT_EQ(shape_options(stage_setting(front, first, Stage::kShape)).model.cloud.spacing, 0.006);
  grasp::PlannerOptions plan;
  apply_plan_setting(stage_setting(front, first, Stage::kPlan), &plan);
  EXPECT_EQ(plan.candidates.circles.rolls, 6);
  EXPECT_EQ(stage_setting(front, first, Stage::kPlan).seconds, first.seconds) << "of the chain";
}

// Its pictures would be matched by whatever the defaults are, outside of the budget.
TEST(ChainSettings, OfImagesAreRefusedForACloudAndTheOtherWayRound) {
  const Front images = three_chains();
  Front clouds = images;
  for (Setting& setting : clouds.settings) {
    setting.knobs[0] = {"segmentation.clustering", "organized"};
    setting.other_errors[1].first = "segmentation";
  }
  const Setting& of_cloud = clouds.settings[0];
  EXPECT_TRUE(begins_with(of_cloud, ChainInput::kCloud));
  EXPECT_FALSE(begins_with(of_cloud, ChainInput::kImages));
  SeeingOptions seeing;
  seeing.segmentation.min_height = 0.012;
  apply_first_stage(clouds, of_cloud, &seeing);
  EXPECT_EQ(seeing.segmentation.clustering, perception::Clustering::kOrganized);
  EXPECT_EQ(seeing.segmentation.min_height, 0.012);
  EXPECT_EQ(seeing.points, 0);
  const double least = seeing.segmentation.min_object_height;
  apply_segmentation_setting({{{"points", "50000"}}, 0, 0}, &seeing);
  EXPECT_EQ(seeing.points, 50000);
  EXPECT_EQ(seeing.segmentation.min_object_height, least) << "what was measured is no noisier";
  apply_segmentation_setting({{{"table_leaf", "0.016"}}, 0, 0}, &seeing);
  EXPECT_EQ(seeing.table.leaf_size, 0.016);
  for (const auto& [knob, value] : {std::pair("points", "3"), std::pair("binning", "3"),
                                    std::pair("table_leaf", "0"), std::pair("table_leaf", "1")}) {
    EXPECT_THROW(apply_segmentation_setting({{{knob, value}}, 0, 0}, &seeing), InputError) << knob;
    EXPECT_THROW(apply_seeing_setting({{{knob, value}}, 0, 0}, &seeing), InputError) << knob;
  }
  EXPECT_THAT(measured_text(clouds, of_cloud), HasSubstr("from a cloud to grasps"));
  EXPECT_THAT([&] { stage_setting(clouds, of_cloud, Stage::kSeeing); },
              ::testing::ThrowsMessage<InputError>(
                  AllOf(HasSubstr("begin with a recorded cloud"), HasSubstr("chain.yaml"))));
  EXPECT_THAT([&] { stage_setting(images, images.settings[0], Stage::kSegmentation); },
              ::testing::ThrowsMessage<InputError>(
                  AllOf(HasSubstr("begin with images"), HasSubstr("chain_cloud.yaml"))));
  EXPECT_NO_THROW(stage_setting(clouds, of_cloud, Stage::kPlan));
  EXPECT_THROW(apply_segmentation_setting({{{"stereo", "semi_global"}}, 0, 0}, &seeing),
               InputError);
  apply_segmentation_setting({{{"points", "all"}}, 0, 0}, &seeing);
  EXPECT_EQ(seeing.points, 0);
  EXPECT_THROW(chain_input("clod"), InputError);
}

TEST(ChainSettings, AFrontOfTheStageAloneIsTakenAsItIs) {
  Front shape;
  shape.subject = "shape";
  shape.settings = {{{{"spacing", "0.003"}}, 0.1, 0.002}};
  EXPECT_EQ(stage_setting(shape, shape.settings[0], Stage::kShape).knobs, shape.settings[0].knobs);
  EXPECT_THROW(stage_setting(shape, shape.settings[0], Stage::kPlan), InputError);
}

TEST(ChainSettings, KnobsOfNoStageAndBadValuesAreRefused) {
  Front front = three_chains();
  for (const char* knob : {"touch.engine", "stereo", ".stereo", ""}) {
    front.settings[0].knobs = {{knob, "x"}};
    EXPECT_THROW(stage_setting(front, front.settings[0], Stage::kShape), InputError) << knob;
  }
  SeeingOptions seeing;
  for (const auto& [knob, value] :
       {std::pair{"stereo", "laser"}, std::pair{"clustering", "kmeans"}, std::pair{"leaf", "1"},
        std::pair{"binning", "3"}, std::pair{"search", "some"}}) {
    EXPECT_THROW(apply_seeing_setting({{{knob, value}}, 0, 0}, &seeing), InputError)
        << knob << " " << value;
  }
}

// Binned pictures are noisier.
TEST(ChainSettings, BinningRaisesTheLeastHeightOfObjects) {
  const double own = perception::SegmentationOptions{}.min_object_height;
  const Setting setting{
      {{"binning", "4"}, {"search", "narrow"}, {"clustering", "organized"}}, 0, 0};
  SeeingOptions seeing;
  apply_seeing_setting(setting, &seeing);
  EXPECT_EQ(seeing.binning, 4);
  EXPECT_TRUE(seeing.stereo.narrow_search);
  EXPECT_DOUBLE_EQ(seeing.segmentation.min_object_height, 4 * own);
  seeing.segmentation.min_object_height = 0.1;  // asked for
  apply_seeing_setting(setting, &seeing);
  EXPECT_DOUBLE_EQ(seeing.segmentation.min_object_height, 0.1);
}

// A budget chooses by what is lifted, a tolerance by the meshes, of which a chain's error is not.
TEST(ChainSettings, ToleranceIsOfMeshes) {
  const Front front = three_chains();
  EXPECT_EQ(choose_for_stage(front, 0.25, 0).seconds, 0.2);
  EXPECT_EQ(choose_for_stage(front, 0, 0.003).seconds, 0.2);
  EXPECT_EQ(choose_for_stage(front, 0, 0.01).seconds, 0.1);
  EXPECT_EQ(choose_for_stage(front, 0, 0.002).seconds, 0.4);
  EXPECT_THROW(choose_for_stage(front, 0, 0.001), UnreachableError);
  EXPECT_THROW(choose_for_stage(front, 0.01, 0), UnreachableError);
  EXPECT_THROW(choose_for_stage(front, 1, 1), InputError) << "both";
  Front silent = front;
  for (Setting& setting : silent.settings) setting.other_errors.clear();
  EXPECT_THROW(choose_for_stage(silent, 0, 0.003), InputError);
}

// What the stages before take is not left for planning.
TEST(ChainSettings, PlanningEndsWithinTheBudgetOfTheChain) {
  const Front front = three_chains();
  grasp::PlannerOptions options;
  EXPECT_THAT(apply_plan_front(front, 0.25, 0, &options).text, HasSubstr("10 % of the views"));
  EXPECT_EQ(options.candidates.circles.rolls, 8);
  EXPECT_NEAR(options.budget, 0.25 - 0.8 * 0.2, 1e-12);
  EXPECT_THAT(apply_plan_front(front, 0.05, 0, &options).text, HasSubstr("cut off"));
  EXPECT_GT(options.budget, 0);
  options.budget = 0;
  apply_plan_front(front, 0, 0.002, &options);
  EXPECT_EQ(options.candidates.circles.rolls, 12);
  EXPECT_EQ(options.budget, 0) << "a tolerance ends nothing";
}

// What follows the hand's grasps: only a chain says something of it.
TEST(ChainSettings, MotionsAndPredictedTouchAreChosenToo) {
  Front front = three_chains();
  front.settings[0].knobs.emplace_back("motion.grasps", "1");
  front.settings[0].knobs.emplace_back("simulation.step", "none");
  front.settings[1].knobs.emplace_back("simulation.step", "0.01");
  const robot::HandModel hand = robot::read_hand_model("config/robots/sdh2.yaml");
  planning::PlatformPlanOptions options(hand);
  options.touch.emplace();
  planning::apply_motion_setting(front, front.settings[1], &options);
  EXPECT_EQ(options.motions, 3) << "as it was";
  ASSERT_TRUE(options.touch);
  EXPECT_EQ(options.touch->world.step, 0.01);
  planning::apply_motion_setting(front, front.settings[0], &options);
  EXPECT_EQ(options.motions, 1);
  EXPECT_FALSE(options.touch);
  planning::apply_motion_setting(front, front.settings[1], &options);
  EXPECT_FALSE(options.touch) << "nobody predicts what was not asked for";
  for (const auto& [knob, value] :
       {std::pair("motion.grasps", "0"), std::pair("motion.grasps", "some"),
        std::pair("motion.speed", "1"), std::pair("simulation.step", "0"),
        std::pair("simulation.step", "1"), std::pair("simulation.engine", "native")}) {
    EXPECT_THROW(planning::apply_motion_setting(front, {{{knob, value}}, 0, 0}, &options),
                 InputError)
        << knob;
  }
  Front plans;
  plans.subject = "plan";
  EXPECT_NO_THROW(planning::apply_motion_setting(plans, {{{"rolls", "6"}}, 0, 0}, &options));
}

TEST(ShippedChains, AreWholeAndUnderstood) {
  for (const char* file :
       {"chain.yaml", "chain_hand.yaml", "chain_cloud.yaml", "chain_cloud_hand.yaml"}) {
    const Front front = read_front(std::filesystem::path("config/fidelity") / file);
    planning::PlatformPlanOptions options(robot::read_hand_model("config/robots/sdh2.yaml"));
    const bool of_cloud = std::string(file).find("cloud") != std::string::npos;
    const ChainInput input = of_cloud ? ChainInput::kCloud : ChainInput::kImages;
    const Stage first = first_stage(input);
    EXPECT_EQ(front.subject, "chain");
    for (const Setting& setting : front.settings) {
      SeeingOptions seeing;
      grasp::PlannerOptions plan;
      EXPECT_TRUE(begins_with(setting, input));
      EXPECT_NO_THROW(apply_first_stage(front, setting, &seeing));
      EXPECT_NO_THROW(shape_options(stage_setting(front, setting, Stage::kShape)));
      EXPECT_NO_THROW(apply_plan_setting(stage_setting(front, setting, Stage::kPlan), &plan));
      EXPECT_NO_THROW(planning::apply_motion_setting(front, setting, &options));
      EXPECT_GT(tolerated_error(front, setting), 0);
      EXPECT_NEAR(stage_seconds(setting, first) + stage_seconds(setting, Stage::kShape) +
                      stage_seconds(setting, Stage::kPlan),
                  setting.seconds, 1e-3 * setting.seconds);
    }
  }
}

}  // namespace
}  // namespace prehend::fidelity
