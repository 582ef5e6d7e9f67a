#include "prehend/fidelity/front.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/fidelity/plan_settings.h"
#include "prehend/fidelity/shape_settings.h"
#include "prehend/fidelity/touch_settings.h"

namespace prehend::fidelity {
namespace {

using geometry::InputError;
using ::testing::HasSubstr;

Setting setting(double milliseconds, double millimetres) {
  return {{{"name", std::to_string(milliseconds)}}, milliseconds / 1000, millimetres / 1000};
}

Front three() {
  Front front;
  front.subject = "shape";
  front.error_name = "mean deviation";
  front.machine = "a test";
  front.other_errors = {{"worst", "largest deviation [m]"}};
  front.settings = {setting(5, 4), setting(20, 3), setting(90, 2.5)};
  for (Setting& one : front.settings) one.other_errors = {{"worst", 4 * one.error}};
  return front;
}

TEST(ParetoFront, KeepsWhatNothingBeats) {
  std::mt19937_64 random(1);
  std::vector<Setting> measured;
  for (int i = 0; i < 300; ++i) {
    measured.push_back(
        setting(static_cast<double>(random() % 50), static_cast<double>(random() % 50)));
  }
  const std::vector<Setting> front = pareto_front(measured);
  ASSERT_FALSE(front.empty());
  for (std::size_t i = 1; i < front.size(); ++i) {
    EXPECT_GT(front[i].seconds, front[i - 1].seconds);
    EXPECT_LT(front[i].error, front[i - 1].error);
  }
  for (const Setting& m : measured) {
    bool covered = false;
    for (const Setting& f : front) covered |= f.seconds <= m.seconds && f.error <= m.error;
    EXPECT_TRUE(covered);
  }
  EXPECT_TRUE(pareto_front({}).empty());
  EXPECT_THROW(pareto_front({setting(NAN, 1)}), std::invalid_argument);
  EXPECT_THROW(pareto_front({setting(-1, 1)}), std::invalid_argument);
}

TEST(Choice, BestWithinBudgetAndFastestWithinTolerance) {
  const Front front = three();
  EXPECT_EQ(within_budget(front, 0.020).error, 0.003);
  EXPECT_EQ(within_budget(front, 0.0199).error, 0.004);
  EXPECT_EQ(within_budget(front, 10).error, 0.0025);
  EXPECT_EQ(within_tolerance(front, 0.003).seconds, 0.020);
  EXPECT_EQ(within_tolerance(front, 1).seconds, 0.005);
}

TEST(Choice, NamesTheNearestWhenThereIsNone) {
  try {
    within_budget(three(), 0.001);
    FAIL();
  } catch (const UnreachableError& error) {
    EXPECT_EQ(error.nearest().seconds, 0.005);
    EXPECT_THAT(error.what(), HasSubstr("5 ms, 4 mm"));
  }
  try {
    within_tolerance(three(), 0.001);
    FAIL();
  } catch (const UnreachableError& error) {
    EXPECT_EQ(error.nearest().error, 0.0025);
    EXPECT_THAT(error.what(), HasSubstr("90 ms, 2.5 mm"));
  }
  EXPECT_THROW(within_budget({}, 1), std::invalid_argument);
  EXPECT_THROW(within_budget(three(), NAN), std::invalid_argument);
  EXPECT_THROW(within_tolerance(three(), 0), std::invalid_argument);
}

TEST(Choice, IsByOneOfTheTwo) {
  EXPECT_EQ(choose(three(), 0.020, 0).error, 0.003);
  EXPECT_EQ(choose(three(), 0, 0.003).seconds, 0.020);
  EXPECT_THROW(choose(three(), 0.020, 0.003), InputError);
  EXPECT_THROW(choose(three(), 0, 0), std::invalid_argument);
}

class FrontFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = std::filesystem::temp_directory_path() / "prehend-front-XXXXXX";
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

TEST_F(FrontFile, ComesBackAsItWasWritten) {
  const std::filesystem::path file = folder_ / "shape.yaml";
  write_front(file, three());
  const Front back = read_front(file);
  EXPECT_EQ(back.subject, "shape");
  EXPECT_EQ(back.machine, "a test");
  ASSERT_EQ(back.settings.size(), 3U);
  EXPECT_DOUBLE_EQ(back.settings[1].seconds, 0.02);
  EXPECT_DOUBLE_EQ(back.settings[2].error, 0.0025);
  EXPECT_EQ(back.settings[0].knobs, three().settings[0].knobs);
  EXPECT_EQ(back.other_errors, three().other_errors);
  EXPECT_EQ(back.settings[2].other_errors, three().settings[2].other_errors);
  EXPECT_THROW(write_front(folder_ / "no" / "x.yaml", three()), InputError);
}

TEST_F(FrontFile, BadFilesAreRefused) {
  const std::string head = "subject: shape\nerror_name: x\nerror_unit: m\nmachine: y\n";
  const std::string first = "settings:\n  - {milliseconds: 5, error: 0.1, knobs: {a: b}}\n";
  const std::filesystem::path file = folder_ / "front.yaml";
  EXPECT_THROW(read_front(file), InputError);
  std::ofstream(file) << head << first;
  EXPECT_EQ(read_front(file).settings.size(), 1U);
  for (const std::string& text :
       {std::string(), std::string("[1, 2]"), std::string("a: ["), head, head + "settings: []\n",
        head + first + "speed: 3\n",
        head + "settings:\n  - {milliseconds: x, error: 1, knobs: {}}\n",
        head + "settings:\n  - {milliseconds: 1, error: .nan, knobs: {}}\n",
        head + first + "  - {milliseconds: 6, error: 0.2, knobs: {a: b}}\n",
        head + "other_errors: 3\n" + first, head + "other_errors: {worst: in m}\n" + first,
        head + "settings:\n  - {milliseconds: 5, error: 1, other_errors: {x: 1}, knobs: {}}\n",
        head + "other_errors: {worst: in m}\n" +
            "settings:\n  - {milliseconds: 5, error: 1, other_errors: {x: 1}, knobs: {}}\n"}) {
    std::ofstream(file) << text;
    EXPECT_THROW(read_front(file), InputError) << text;
  }
}

TEST(ShapeSettings, SetTheOptionsTheyName) {
  const ShapeOptions options = shape_options({{{"thinning", "0.05"},
                                               {"orientations", "31"},
                                               {"shifts", "21"},
                                               {"refine", "no"},
                                               {"spacing", "0.003"},
                                               {"surface", "pcl"},
                                               {"resolution", "6"}},
                                              0,
                                              0});
  EXPECT_EQ(options.completion.thinning, 0.05);
  EXPECT_EQ(options.completion.orientations, 31);
  EXPECT_EQ(options.completion.shifts, 21);
  EXPECT_FALSE(options.completion.refine);
  EXPECT_EQ(options.model.cloud.spacing, 0.003);
  EXPECT_EQ(options.model.surface.method, surface::SurfaceMethod::kPclPoisson);
  EXPECT_EQ(options.model.surface.pcl_poisson.depth, 6);
  EXPECT_EQ(shape_options({{{"resolution", "64"}}, 0, 0}).model.surface.fast_poisson.resolution,
            64);
  for (const auto& [knob, value] :
       {std::pair{"thinning", "much"}, std::pair{"shifts", "3.5"}, std::pair{"refine", "perhaps"},
        std::pair{"surface", "slow"}, std::pair{"colour", "red"}, std::pair{"resolution", ""}}) {
    EXPECT_THROW(shape_options({{{knob, value}}, 0, 0}), InputError) << knob;
  }
}

TEST(PlanSettings, SetTheOptionsTheyName) {
  grasp::PlannerOptions options;
  options.density = 500;
  apply_plan_setting({{{"generators", "circles+antipodal"},
                       {"rolls", "8"},
                       {"standoffs", "4"},
                       {"offsets", "5"},
                       {"samples", "0"},
                       {"count", "12"},
                       {"enough", "1"},
                       {"first_share", "16"},
                       {"further", "none"}},
                      0,
                      0},
                     &options);
  EXPECT_THAT(options.generators, ::testing::ElementsAre("circles", "antipodal"));
  EXPECT_EQ(options.candidates.circles.rolls, 8);
  EXPECT_EQ(options.candidates.circles.standoffs, 4);
  EXPECT_THAT(options.candidates.circles.lateral_offsets,
              ::testing::ElementsAre(0, -0.015, 0.015, -0.03, 0.03));
  EXPECT_EQ(options.uncertainty.samples, 0);
  EXPECT_EQ(options.largest_count, 12);
  EXPECT_EQ(options.enough_grasps, 1);
  EXPECT_EQ(options.first_share, 16);
  EXPECT_THAT(options.further_generators, ::testing::IsEmpty());
  EXPECT_EQ(options.density, 500) << "no knob names it";
  EXPECT_NO_THROW(options.validate());
  for (const auto& [knob, value] :
       {std::pair{"generators", "circles+squares"}, std::pair{"generators", ""},
        std::pair{"rolls", "0"}, std::pair{"standoffs", "2.5"}, std::pair{"offsets", "4"},
        std::pair{"samples", "-1"}, std::pair{"count", "many"}, std::pair{"enough", "-1"},
        std::pair{"first_share", "0"}, std::pair{"further", "some"}, std::pair{"colour", "red"}}) {
    EXPECT_THROW(apply_plan_setting({{{knob, value}}, 0, 0}, &options), InputError)
        << knob << " " << value;
  }
}

TEST(PlanSettings, TheBudgetChoosesAndEndsPlanning) {
  Front front;
  front.subject = "plan";
  front.settings = {{{{"rolls", "6"}}, 0.1, 0.3}, {{{"rolls", "24"}}, 0.4, 0.1}};
  grasp::PlannerOptions options;
  EXPECT_THAT(apply_plan_front(front, 0.5, 0, &options).text, HasSubstr("rolls 24"));
  EXPECT_EQ(options.candidates.circles.rolls, 24);
  EXPECT_EQ(options.budget, 0.5);
  EXPECT_THAT(apply_plan_front(front, 0.2, 0, &options).text, HasSubstr("rolls 6"));
  EXPECT_EQ(options.candidates.circles.rolls, 6);
  options.candidates.circles.rolls = 1;
  EXPECT_THAT(apply_plan_front(front, 0.05, 0, &options).text, HasSubstr("cut off"));
  EXPECT_EQ(options.candidates.circles.rolls, 6) << "the fastest there is";
  EXPECT_EQ(options.budget, 0.05);
  EXPECT_THROW(apply_plan_front(front, -1, 0, &options), std::invalid_argument);
}

// The shipped fronts can be read and every setting of them is understood.
TEST(ShippedFronts, AreWhole) {
  const Front front = read_front("config/fidelity/shape.yaml");
  EXPECT_EQ(front.subject, "shape");
  for (const Setting& one : front.settings) EXPECT_NO_THROW(shape_options(one));
  const Front plan = read_front("config/fidelity/plan.yaml");
  EXPECT_EQ(plan.subject, "plan");
  grasp::PlannerOptions planner;
  for (const Setting& one : plan.settings) EXPECT_NO_THROW(apply_plan_setting(one, &planner));
  const Front touch = read_front("config/fidelity/touch.yaml");
  EXPECT_EQ(touch.subject, "touch");
  simulation::Scene scene;
  for (const Setting& one : touch.settings) EXPECT_NO_THROW(apply_touch_setting(one, &scene));
  EXPECT_LT(within_tolerance(touch, 0.03).seconds, 1.0 / 50) << "faster than 50 times real time";
  const Front hand = read_front("config/fidelity/touch_hand.yaml");
  EXPECT_EQ(hand.subject, "touch_hand");
  for (const Setting& one : hand.settings) EXPECT_GT(touch_hand_step(one), 0);
  const Front engines = read_front("config/fidelity/touch_engines.yaml");
  EXPECT_EQ(engines.subject, "touch_engines");
  for (const Setting& one : engines.settings) EXPECT_NO_THROW(engine_choice(one));
}

}  // namespace
}  // namespace prehend::fidelity
