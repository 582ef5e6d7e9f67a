// Which case runs next.

#include "prehend/sweep/handout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prehend::testing {
namespace {

using sweep::Handout;
using ::testing::ElementsAre;

std::vector<std::int64_t> rest(Handout& handout) {
  std::vector<std::int64_t> order;
  while (const auto next = handout.next()) order.push_back(*next);
  return order;
}

TEST(Handouts, BeginWithUnknownThenLongestCases) {
  Handout handout({{0, 1.0}, {1, 9.0}, {2, {}}, {3, 4.0}, {4, 9.0}, {5, {}}});
  EXPECT_EQ(handout.total(), 6);
  EXPECT_THAT(rest(handout), ElementsAre(2, 5, 1, 4, 3, 0));
}

TEST(Handouts, GiveLostCasesAgainButNotForEver) {
  Handout handout({{7, {}}, {8, {}}});
  EXPECT_EQ(handout.next(), 7);
  EXPECT_TRUE(handout.lost(7));
  EXPECT_EQ(handout.next(), 7);
  EXPECT_EQ(handout.next(), 8);
  EXPECT_EQ(handout.next(), std::nullopt);
  EXPECT_TRUE(handout.lost(7));
  EXPECT_EQ(handout.next(), 7);
  EXPECT_FALSE(handout.lost(7)) << "the third time";
  EXPECT_EQ(handout.next(), std::nullopt);
  EXPECT_TRUE(handout.lost(8)) << "each case has its own attempts";
}

}  // namespace
}  // namespace prehend::testing
