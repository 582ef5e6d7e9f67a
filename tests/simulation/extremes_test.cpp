#include "eval/touch/extremes.h"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

namespace prehend::eval::touch {
namespace {

// The table that people read says what the code does.
TEST(Extremes, AreStableOrRefusedAsTheTableSays) {
  std::ifstream file("docs/touch_extremes.md");
  ASSERT_TRUE(file) << "run from the source tree";
  std::stringstream text;
  text << file.rdbuf();
  const std::string table = text.str();
  const std::vector<Extreme> cases = extremes();
  EXPECT_GE(cases.size(), 40u);
  for (const Extreme& extreme : cases) {
    const ExtremeResult result = run_extreme(extreme, false);
    if (extreme.refused.empty()) {
      EXPECT_TRUE(result.stable) << extreme.subject << ' ' << extreme.value << ": energy "
                                 << result.energy_growth << ", speed " << result.final_speed;
    } else {
      EXPECT_NE(result.message.find(extreme.refused), std::string::npos) << result.message;
    }
    const std::string row =
        "| " + extreme.subject + " | " + extreme.value + " | " + outcome(result) + " |";
    EXPECT_NE(table.find(row), std::string::npos) << "not in docs/touch_extremes.md: " << row;
  }
}

}  // namespace
}  // namespace prehend::eval::touch
