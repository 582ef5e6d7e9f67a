#include "prehend/fidelity/touch_choice.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/fidelity/touch_settings.h"
#include "prehend/robot/platform.h"

namespace prehend::fidelity {
namespace {

using geometry::InputError;
using ::testing::HasSubstr;

TEST(TouchSettings, SetHowASceneIsSteppedAndNothingElse) {
  simulation::Scene scene;
  scene.physics.rules.sleep = false;
  apply_touch_setting({{{"integration", "adaptive"},
                        {"step", "0.002"},
                        {"tolerance", "1e-06"},
                        {"iterations", "2"}},
                       0,
                       0},
                      &scene);
  EXPECT_TRUE(scene.physics.adaptive);
  EXPECT_EQ(scene.step, 0.002);
  EXPECT_EQ(scene.physics.tolerance, 1e-6);
  EXPECT_EQ(scene.physics.most_iterations, 2);
  EXPECT_FALSE(scene.physics.rules.sleep) << "no knob names it";
  apply_touch_setting({{{"integration", "second_order"}}, 0, 0}, &scene);
  EXPECT_FALSE(scene.physics.adaptive);
  EXPECT_EQ(scene.physics.integration, contact::Integration::kSecondOrder);
  EXPECT_EQ(scene.step, 0.002);
  // Rows and columns are the pad's: a published frame has its real size.
  for (const auto& [knob, value] :
       {std::pair{"integration", "explicit"}, std::pair{"step", "0"}, std::pair{"step", "nan"},
        std::pair{"step", "-1"}, std::pair{"tolerance", "big"}, std::pair{"iterations", "0"},
        std::pair{"iterations", "2.5"}, std::pair{"rows", "7"}, std::pair{"colour", "red"}}) {
    EXPECT_THROW(apply_touch_setting({{{knob, value}}, 0, 0}, &scene), InputError) << knob << value;
  }
  EXPECT_EQ(touch_hand_step({{{"step", "0.004"}}, 0, 0}), 0.004);
  EXPECT_THROW(touch_hand_step({{}, 0, 0}), InputError);
  EXPECT_THROW(touch_hand_step({{{"step", "0.004"}, {"integration", "adaptive"}}, 0, 0}),
               InputError);
}

TEST(TouchSettings, ChooseAnEngine) {
  const EngineChoice choice = engine_choice(
      {{{"engine", "ode"}, {"solver", "step"}, {"pads", "no"}, {"step", "0.01"}}, 0, 0});
  EXPECT_EQ(choice.engine, "ode");
  EXPECT_EQ(choice.solver, "step");
  EXPECT_FALSE(choice.pads);
  EXPECT_EQ(choice.step, 0.01);
  for (const auto& [knob, value] : {std::pair{"engine", ""}, std::pair{"pads", "some"},
                                    std::pair{"step", "1e9"}, std::pair{"texels", "3"}}) {
    EXPECT_THROW(engine_choice({{{knob, value}}, 0, 0}), InputError) << knob << value;
  }
}

// A front "touch" of two settings, and a scene file beside it.
class TouchChoice : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = std::filesystem::temp_directory_path() / "prehend-touch-XXXXXX";
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  TouchRequest request(const std::string& subject, const std::string& slow,
                       const std::string& fast) {
    TouchRequest made;
    made.front = folder_ / (subject + ".yaml");
    std::ofstream(made.front)
        << "subject: " << subject
        << "\nerror_name: images\nerror_unit: of the largest sum\n"
           "other_errors: {motion: '[m]'}\nmachine: a test\nsettings:\n"
           "  - {milliseconds: 2, error: 0.05, other_errors: {motion: 0.003}, "
           "knobs: {"
        << fast
        << "}}\n  - {milliseconds: 8, error: 0.01, other_errors: {motion: "
           "0.001}, knobs: {"
        << slow << "}}\n";
    return made;
  }
  simulation::Scene scene(const std::string& text) {
    std::ofstream(folder_ / "scene.yaml") << text;
    return simulation::read_scene(folder_ / "scene.yaml");
  }
  static robot::Platform platform(const std::string& name) {
    return robot::read_platform("config/robots/" + name + ".yaml");
  }
  std::string refusal(const TouchRequest& request, const robot::Platform& platform,
                      simulation::Scene scene) {
    try {
      choose_touch(request, platform, &scene);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  std::filesystem::path folder_;
};

TEST_F(TouchChoice, SetsTheStepsOfTheWorldOfThePlatform) {
  TouchRequest stage = request("touch", "integration: second_order, step: 0.002", "step: 0.005");
  stage.tolerance = 0.02;
  simulation::Scene of_stage = scene("objects: [{name: box}]\n");
  const ChosenTouch slow = choose_touch(stage, platform("stage_pg70"), &of_stage);
  EXPECT_EQ(of_stage.physics.integration, contact::Integration::kSecondOrder);
  EXPECT_EQ(of_stage.step, 0.002);
  EXPECT_THAT(slow.text, HasSubstr("integration second_order, step 0.002: 8 ms of processor"));
  EXPECT_THAT(slow.text, HasSubstr("pads' images 1 % of the largest sum"));
  EXPECT_THAT(slow.text, HasSubstr("objects 1 mm"));
  stage.tolerance = 0;
  stage.budget = 0.003;
  choose_touch(stage, platform("stage_pg70"), &of_stage);
  EXPECT_EQ(of_stage.step, 0.005);

  TouchRequest hand = request("touch_hand", "step: 0.001", "step: 0.01");
  hand.budget = 0.003;
  simulation::Scene of_hand = scene("objects: [{name: box}]\n");
  choose_touch(hand, platform("kr5_sdh"), &of_hand);
  EXPECT_EQ(of_hand.step, 0.01);
  EXPECT_THAT(refusal(stage, platform("kr5_sdh"), of_hand), HasSubstr("is of 'touch'"));
  EXPECT_THAT(refusal(hand, platform("stage_pg70"), of_stage), HasSubstr("is of 'touch_hand'"));
}

TEST_F(TouchChoice, RefusesWhatCannotBeOrIsSaidTwice) {
  const robot::Platform stage = platform("stage_pg70");
  TouchRequest asked = request("touch", "step: 0.001", "step: 0.01");
  asked.tolerance = 0.001;
  EXPECT_THAT(refusal(asked, stage, scene("gravity: 9.8\n")),
              HasSubstr("Allow as much as the most accurate one: 8 ms, 0.01 of the largest sum"));
  asked.tolerance = 0;
  asked.budget = 0.001;
  EXPECT_THAT(refusal(asked, stage, scene("gravity: 9.8\n")),
              HasSubstr("Allow as much as the fastest one: 2 ms"));
  asked.tolerance = 0.1;
  EXPECT_THAT(refusal(asked, stage, scene("gravity: 9.8\n")),
              HasSubstr("budget and tolerance are both given"));
  asked.budget = 0;
  for (const auto& [text, part] :
       {std::pair{"step: 0.002\n", "scene.yaml:1: step stands beside"},
        std::pair{"gravity: 9.8\nphysics:\n  step: adaptive\n",
                  "scene.yaml:3: physics.step stands beside"},
        std::pair{"physics: {integration: second_order}\n", "physics.integration stands beside"},
        std::pair{"physics: {most_iterations: 3}\n", "physics.most_iterations stands beside"},
        std::pair{"physics: {pads: rigid}\n", "physics.pads stands beside"}}) {
    EXPECT_THAT(refusal(asked, stage, scene(text)), HasSubstr(part)) << text;
  }
  EXPECT_EQ(refusal(asked, stage, scene("physics: {rules: {sleep: false}}\n")), "");
  robot::Platform unfeeling = platform("kr5_sdh");
  unfeeling.hand.pads.clear();
  EXPECT_THAT(refusal(asked, unfeeling, scene("gravity: 9.8\n")),
              HasSubstr("whose hand has no pads"));
}

}  // namespace
}  // namespace prehend::fidelity
