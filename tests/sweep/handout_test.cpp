#include "prehend/sweep/handout.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prehend::sweep {
namespace {

std::vector<std::int64_t> all_of(Handout& handout) {
  std::vector<std::int64_t> order;
  while (const auto next = handout.next()) order.push_back(*next);
  return order;
}

TEST(SweepHandout, TheLongestBeginsFirstAfterThoseOfUnknownLength) {
  Handout handout({{0, 1.0}, {1, 5.0}, {2, {}}, {3, 5.0}, {4, {}}});
  EXPECT_THAT(all_of(handout), ::testing::ElementsAre(2, 4, 1, 3, 0));
}

TEST(SweepHandout, WhatIsLostComesAgainAndNotForEver) {
  Handout handout({{0, {}}, {1, {}}});
  EXPECT_EQ(handout.next(), 0);
  EXPECT_TRUE(handout.lost(0));
  EXPECT_EQ(handout.next(), 0) << "at once";
  EXPECT_TRUE(handout.lost(0));
  EXPECT_EQ(handout.next(), 0);
  EXPECT_FALSE(handout.lost(0)) << "after three";
  EXPECT_EQ(handout.next(), 1);
  EXPECT_EQ(handout.next(), std::nullopt);
}

}  // namespace
}  // namespace prehend::sweep
