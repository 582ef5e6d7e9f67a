#include "eval/touch/tradeoff.h"

#include <cmath>

#include <gtest/gtest.h>

#include "eval/touch/felt_cycles.h"
#include "prehend/fidelity/touch_settings.h"

namespace prehend::eval::touch {
namespace {

fidelity::Setting setting(std::vector<std::pair<std::string, std::string>> knobs) {
  fidelity::Setting made;
  made.knobs = std::move(knobs);
  return made;
}

// A pad of rows x columns texels under the pressure p(x, y) = 1 + x + 2 y on the unit square [N].
PadFrame sloped(int rows, int columns) {
  PadFrame frame{rows, columns, {}};
  for (int i = 0; i < rows; ++i) {
    for (int k = 0; k < columns; ++k) {
      const double x = (k + 0.5) / columns, y = (i + 0.5) / rows;
      frame.force.push_back((1 + x + 2 * y) / (rows * columns));
    }
  }
  return frame;
}

TEST(ImageDistance, IsTheSumOfTexelsDifferencesOnOneGrid) {
  const PadFrame a{2, 2, {1, 2, 3, 4}}, b{2, 2, {1, 0, 3.5, 4}};
  EXPECT_DOUBLE_EQ(image_distance(a, b), 2.5);
  EXPECT_DOUBLE_EQ(image_distance(b, a), 2.5);
  EXPECT_EQ(image_distance(a, a), 0);
  // A load that moves from one texel to another is no difference of sums, but twice itself here.
  const PadFrame left{1, 3, {6, 0, 0}}, right{1, 3, {0, 0, 6}};
  EXPECT_DOUBLE_EQ(image_distance(left, right), 12);
}

TEST(ImageDistance, ComparesPressuresWhereOtherGridsOverlap) {
  const PadFrame even{1, 2, {3, 3}}, finer{1, 3, {2, 2, 2}};
  EXPECT_NEAR(image_distance(even, finer), 0, 1e-15) << "one pressure all over";
  // Halves of 4 and 2 N against thirds of 2 N: |8 - 6| on one half, |4 - 6| on the other.
  EXPECT_NEAR(image_distance({1, 2, {4, 2}}, finer), 2, 1e-15);
  // A slope on cells of 1/n differs from that on cells of 1/2n by s/4n everywhere, of either axis.
  const double s_x = 1, s_y = 2;
  EXPECT_NEAR(image_distance(sloped(1, 3), sloped(1, 6)), s_x / 12, 1e-12);
  EXPECT_NEAR(image_distance(sloped(7, 1), sloped(14, 1)), s_y / 28, 1e-12);
  EXPECT_NEAR(sloped(7, 3).sum(), sloped(14, 6).sum(), 1e-12);
  EXPECT_THROW(image_distance({1, 2, {1}}, finer), std::invalid_argument);
  EXPECT_THROW(image_distance({0, 0, {}}, finer), std::invalid_argument);
}

TEST(FeltError, IsRelativeToTheLargestSumAndOverWhatIsTouched) {
  FeltRun reference, run;
  const PadFrame none{1, 2, {0, 0}};
  // Nothing, 4 N, 10 N; the run is 1 N short once and has 1 N on the wrong texel the other time.
  reference.frames = {{none}, {{1, 2, {2, 2}}}, {{1, 2, {5, 5}}}};
  run.frames = {{none}, {{1, 2, {1, 2}}}, {{1, 2, {6, 4}}}};
  reference.path = {{0, 0, 0}, {0, 0, 0}, {0, 0, 1}};
  run.path = {{0, 0, 0}, {3e-3, 0, 4e-3}, {0, 0, 1}};
  const FeltError error = felt_error(run, reference);
  EXPECT_NEAR(error.image, std::sqrt((0.01 + 0.04) / 2), 1e-12);
  EXPECT_NEAR(error.sum, std::sqrt(0.01 / 2), 1e-12);
  EXPECT_NEAR(error.largest, 0.2, 1e-12);
  EXPECT_NEAR(error.motion, 5e-3, 1e-12);
  EXPECT_TRUE(error.is_finite());
  EXPECT_EQ(felt_error(reference, reference).image, 0);
  run.path[1].x() = NAN;
  EXPECT_FALSE(felt_error(run, reference).is_finite()) << "must not count as the smaller one";
  run.path.pop_back();
  EXPECT_THROW(felt_error(run, reference), std::invalid_argument);
}

// What is felt says more than where the object is.
TEST(TouchTradeoff, MeasuresErrorsAndTimeOfEachSetting) {
  TouchSweep sweep;
  sweep.repetitions = 1;
  sweep.reference_step = sweep.own_finest_step = 1e-3;
  sweep.cycle = {setting({{"integration", "first_order"}, {"step", "0.01"}}),
                 setting({{"integration", "second_order"}, {"step", "0.001"}})};
  sweep.texels = {setting(
      {{"integration", "second_order"}, {"step", "0.001"}, {"rows", "7"}, {"columns", "3"}})};
  sweep.engines = {setting({{"engine", "native"}, {"step", "0.01"}}),
                   setting({{"engine", "native"}, {"step", "0.01"}, {"pads", "no"}}),
                   setting({{"engine", "native"}, {"solver", "magic"}})};
  const TouchTradeoff tradeoff = measure_touch_tradeoff(sweep, [](const std::string&) {});
  ASSERT_EQ(tradeoff.cycle.size(), 2u);
  const MeasuredTouch &coarse = tradeoff.cycle[0], &fine = tradeoff.cycle[1];
  EXPECT_GT(coarse.error.image, 0.02);
  EXPECT_LT(coarse.error.image, 0.5);
  EXPECT_GE(coarse.error.image, coarse.error.sum - 1e-12);
  EXPECT_GE(coarse.error.largest, coarse.error.image);
  EXPECT_LT(coarse.error.motion, 0.005) << "the object is not lost";
  EXPECT_EQ(fine.error.image, 0) << "the reference's own steps";
  EXPECT_EQ(fine.error.motion, 0);
  EXPECT_GT(fine.setting.seconds, 3 * coarse.setting.seconds);
  // A coarser pad of the same stiffness: sums remain, the image of the can does not.
  ASSERT_EQ(tradeoff.texels.size(), 1u);
  EXPECT_GT(tradeoff.texels[0].error.image, 3 * tradeoff.texels[0].error.sum);
  // Rigid plates feel nothing, and lack what pads give way by: only beside the reference.
  ASSERT_EQ(tradeoff.engines.size(), 2u);
  const MeasuredTouch &pads = tradeoff.engines[0], &plates = tradeoff.engines[1];
  EXPECT_LT(pads.error.motion, 5e-5);
  EXPECT_GT(pads.error.image, 1e-3);
  EXPECT_LT(pads.error.image, 0.05);
  ASSERT_TRUE(pads.own && plates.own);
  EXPECT_NEAR(pads.own->image, pads.error.image, 0.2 * pads.error.image);
  EXPECT_FALSE(plates.feels);
  EXPECT_GT(plates.error.motion, 1e-4);
  EXPECT_LT(plates.error.motion, 1e-3);
  EXPECT_LT(plates.own->motion, 1e-6);
  ASSERT_FALSE(tradeoff.left_out.empty());
  EXPECT_NE(tradeoff.left_out.back().find("magic"), std::string::npos);

  const fidelity::Front front = cycle_front(tradeoff, "here");
  EXPECT_EQ(front.subject, "touch");
  EXPECT_EQ(front.settings.back().error, 0);
  EXPECT_EQ(front.settings.front().other_errors.at(2).first, "motion");
  EXPECT_EQ(front.settings.front().other_errors.at(2).second, coarse.error.motion);
  const fidelity::Front engines = engine_front(tradeoff, "here");
  EXPECT_EQ(engines.subject, "touch_engines");
  ASSERT_EQ(engines.settings.size(), 1u) << "plates feel nothing";
  EXPECT_EQ(engines.settings[0].other_errors.size(), engines.other_errors.size());
}

// A hand's pads are compared as well, and steps are all that changes.
TEST(TouchTradeoff, MeasuresAHand) {
  const CycleRun coarse = run_hand_cycle("sdh2", 0.3, 0.01),
                 fine = run_hand_cycle("sdh2", 0.3, 2e-3);
  const FeltError error = felt_error(coarse.felt, fine.felt);
  EXPECT_GT(error.image, 0);
  EXPECT_LT(error.image, 0.05);
  EXPECT_LT(error.motion, 0.002);
}

TEST(TouchTradeoff, SweepsWhatTheLibraryUnderstands) {
  for (const bool quick : {true, false}) {
    const TouchSweep sweep = touch_sweep(quick);
    simulation::Scene scene;
    for (const fidelity::Setting& one : sweep.cycle) {
      EXPECT_NO_THROW(fidelity::apply_touch_setting(one, &scene));
    }
    for (const fidelity::Setting& one : sweep.hand) EXPECT_GT(fidelity::touch_hand_step(one), 0);
    EXPECT_GE(sweep.engines.size(), 4u);
    for (const fidelity::Setting& one : sweep.engines) {
      EXPECT_NO_THROW(fidelity::engine_choice(one));
    }
  }
}

}  // namespace
}  // namespace prehend::eval::touch
