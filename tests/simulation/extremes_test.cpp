#include "eval/touch/extremes.h"
#include "eval/touch/stability_map.h"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

namespace prehend::eval::touch {
namespace {

// The table that people read says what the code does.
TEST(Extremes, AreHeldOrRefusedAsTheTableSays) {
  std::ifstream file("docs/touch_extremes.md");
  ASSERT_TRUE(file) << "run from the source tree";
  std::stringstream text;
  text << file.rdbuf();
  const std::string table = text.str();
  const std::vector<Extreme> cases = extremes();
  EXPECT_GE(cases.size(), 40u);
  for (const Extreme& extreme : cases) {
    const ExtremeResult result = run_extreme(extreme, false);
    EXPECT_TRUE(is_as_expected(extreme, result))
        << extreme.subject << ' ' << extreme.value << ": " << outcome(extreme, result)
        << ", energy " << result.energy_growth << ", speed " << result.final_speed << ", sliding "
        << result.sliding;
    const std::string row =
        "| " + extreme.subject + " | " + extreme.value + " | " + outcome(extreme, result) + " |";
    EXPECT_NE(table.find(row), std::string::npos) << "not in docs/touch_extremes.md: " << row;
  }
}

TEST(Extremes, WhatSlidesIsNotHeld) {
  Extreme slippery = extremes().front();
  slippery.model.pads[0].law.static_friction = slippery.model.pads[0].law.dynamic_friction = 0.01;
  slippery.model.pads[1].law = slippery.model.pads[0].law;
  const ExtremeResult result = run_extreme(slippery, false);
  EXPECT_FALSE(result.held);
  EXPECT_FALSE(is_as_expected(slippery, result));
  slippery.limit = "its friction bears less than its weight";
  EXPECT_TRUE(is_as_expected(slippery, result));
}

// Each cell of the quick maps is held, or says why not.
TEST(StabilityMaps, HaveNoCellThatIsLostWithoutAReason) {
  const std::vector<StabilityMap> maps = stability_maps(true, [](const std::string&) {});
  EXPECT_GE(maps.size(), 3u);
  for (const StabilityMap& map : maps) {
    SCOPED_TRACE(map.world);
    EXPECT_EQ(map.count(MapCell::Outcome::kLost), 0);
    EXPECT_GE(map.count(MapCell::Outcome::kHeld), 3);
    const report::CellMap drawn = cell_map(map);
    EXPECT_NE(report::draw_cell_map(drawn).find(map.world), std::string::npos);
    for (const report::CellMap::Cell& cell : drawn.cells) EXPECT_FALSE(cell.hint.empty());
  }
}

}  // namespace
}  // namespace prehend::eval::touch
