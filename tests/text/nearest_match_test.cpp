#include "prehend/text/nearest_match.h"

#include <gtest/gtest.h>

namespace prehend::text {
namespace {

TEST(NearestMatch, CountsInsertionsDeletionsSubstitutionsAndSwaps) {
  EXPECT_EQ(edit_distance("", ""), 0u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("abc", ""), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("abcd", "abdc"), 1u);
  EXPECT_EQ(edit_distance("ca", "abc"), 3u);  // the restricted distance edits no part twice
}

TEST(NearestMatch, FindsWhatWasMeantAndNothingFarAway) {
  const std::vector<std::string> names{"simulation", "report", "recorder", "/camera/left"};
  EXPECT_EQ(nearest_match("simulatoin", names), "simulation");
  EXPECT_EQ(nearest_match("Report", names), "report");
  EXPECT_EQ(nearest_match("/camera/lft", names), "/camera/left");
  EXPECT_EQ(nearest_match("sim", names), "simulation");
  EXPECT_EQ(nearest_match("gripper", names), std::nullopt);
  EXPECT_EQ(nearest_match("", names), std::nullopt);
  EXPECT_EQ(nearest_match("x", {}), std::nullopt);
}

TEST(NearestMatch, HintEndsAMessage) {
  EXPECT_EQ(nearest_match_hint("repotr", {"report"}), "; did you mean \"report\"?");
  EXPECT_EQ(nearest_match_hint("zzz", {"a", "b"}), "; known are: a, b");
  EXPECT_EQ(nearest_match_hint("zzz", {}), "");
}

TEST(NearestMatch, MendIsASentence) {
  EXPECT_EQ(nearest_match_mend("repotr", {"report"}), "The nearest is 'report'");
  EXPECT_EQ(nearest_match_mend("zzz", {"a", "b"}), "Known are a, b");
  EXPECT_EQ(nearest_match_mend("zzz", {}), "There is none to choose from");
}

}  // namespace
}  // namespace prehend::text
