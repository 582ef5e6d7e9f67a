#include "eval/touch/tradeoff.h"

#include <cmath>

#include <gtest/gtest.h>

#include "prehend/fidelity/touch_settings.h"

namespace prehend::eval::touch {
namespace {

fidelity::Setting setting(std::vector<std::pair<std::string, std::string>> knobs) {
  fidelity::Setting made;
  made.knobs = std::move(knobs);
  return made;
}

TEST(TouchTradeoff, MeasuresErrorAndTimeOfEachSetting) {
  const TouchTradeoff tradeoff = measure_touch_tradeoff(
      {setting({{"integration", "first_order"}, {"step", "0.02"}}),
       setting({{"integration", "second_order"}, {"step", "0.02"}}),
       setting({{"integration", "second_order"}, {"step", "0.001"}}),
       setting({{"integration", "explicit"}, {"step", "0.01"}})},
      {setting({{"engine", "native"}, {"step", "0.01"}}),
       setting({{"engine", "native"}, {"step", "0.01"}, {"pads", "no"}}),
       setting({{"engine", "native"}, {"solver", "magic"}})},
      1, [](const std::string&) {}, 1e-3);
  // An order more is more accurate, and the reference itself is exact and slower.
  ASSERT_GE(tradeoff.cycle.size(), 3u);
  EXPECT_LT(tradeoff.cycle[1].error, 0.5 * tradeoff.cycle[0].error);
  EXPECT_EQ(tradeoff.cycle[2].error, 0);
  EXPECT_LT(tradeoff.cycle[0].error, 0.005) << "the box is not lost";
  EXPECT_GT(tradeoff.cycle[2].seconds, 3 * tradeoff.cycle[1].seconds);
  // The paper's explicit step is unstable there: not finite, or far from the truth.
  EXPECT_TRUE(tradeoff.cycle.size() == 3 || tradeoff.cycle[3].error > 0.005);
  // Rigid plates lack what pads give way by.
  ASSERT_EQ(tradeoff.engines.size(), 2u);
  EXPECT_LT(tradeoff.engines[0].error, 5e-5);
  EXPECT_GT(tradeoff.engines[1].error, 1e-4);
  EXPECT_LT(tradeoff.engines[1].error, 1e-3);
  ASSERT_FALSE(tradeoff.left_out.empty());
  EXPECT_NE(tradeoff.left_out.back().find("magic"), std::string::npos);

  const fidelity::Front front = cycle_front(tradeoff, "here");
  EXPECT_EQ(front.subject, "touch");
  EXPECT_EQ(front.settings.back().error, 0);
  EXPECT_EQ(engine_front(tradeoff, "here").subject, "touch_engines");
}

TEST(TouchTradeoff, SweepsWhatTheLibraryUnderstands) {
  for (const bool quick : {true, false}) {
    for (const fidelity::Setting& one : swept_cycle_settings(quick)) {
      EXPECT_NO_THROW(fidelity::touch_options(one));
    }
    const auto engines = swept_engine_settings(quick);
    EXPECT_GE(engines.size(), 4u);
    for (const fidelity::Setting& one : engines) EXPECT_NO_THROW(fidelity::engine_choice(one));
  }
}

}  // namespace
}  // namespace prehend::eval::touch
