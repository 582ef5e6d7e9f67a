// Names and arguments of cases.

#include "prehend/sweep/cases.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "prehend/text/input_error.h"

namespace prehend::testing {
namespace {

using namespace sweep;
using ::testing::ElementsAre;

Description two_objects() {
  Description made;
  made.arguments = {"--only", "{object}", "--out={folder}/x", "{{{seed}}}", "{mu}", "{case}"};
  made.grid = {{"object", Values::list({"mug", "cup"})}, {"seed", Values::steps("1", "3", "1")}};
  made.sampled = {{"mu", {Distribution::Kind::kUniform, 0, 1, {}}}};
  made.sample_count = 2;
  return made;
}

TEST(Cases, AreEveryCombinationInOrder) {
  const Description description = two_objects();
  const Cases cases(description);
  ASSERT_EQ(cases.size(), 2 * 3 * 2);
  EXPECT_EQ(cases.at(0).name, "object=mug,seed=1,sample=0");
  EXPECT_EQ(cases.at(1).name, "object=mug,seed=1,sample=1");
  EXPECT_EQ(cases.at(2).name, "object=mug,seed=2,sample=0");
  EXPECT_EQ(cases.at(11).name, "object=cup,seed=3,sample=1");
  std::set<std::string> names;
  for (std::int64_t i = 0; i < cases.size(); ++i) names.insert(cases.at(i).name);
  EXPECT_EQ(names.size(), 12u);
  EXPECT_THROW(cases.at(12), std::out_of_range);
  // The same draw beside each value of the grid.
  EXPECT_EQ(cases.at(0).values[2], cases.at(2).values[2]);
  EXPECT_NE(cases.at(0).values[2], cases.at(1).values[2]);
}

TEST(Cases, PutTheirValuesIntoTheArguments) {
  const Description description = two_objects();
  const Cases cases(description);
  const Case one = cases.at(2);
  EXPECT_THAT(cases.arguments(one, "/tmp/a b"),
              ElementsAre("--only", "mug", "--out=/tmp/a b/x", "{2}", one.values[2].second,
                          "object=mug,seed=2,sample=0"));
}

TEST(Cases, MoreDrawsLeaveThoseThatAreThere) {
  Description description = two_objects();
  const Case before = Cases(description).at(1);
  description.sample_count = 200;
  const Case after = Cases(description).at(1);
  EXPECT_EQ(before.name, after.name);
  EXPECT_EQ(before.values, after.values);
}

TEST(Cases, HaveNamesThatFilesCanHave) {
  Description description;
  description.grid = {{"file", Values::list({"a/b", "a b", "a_b", "..", std::string(300, 'x')})}};
  const Cases cases(description);
  std::set<std::string> names;
  for (std::int64_t i = 0; i < cases.size(); ++i) {
    const std::string name = cases.at(i).name;
    names.insert(name);
    EXPECT_LE(name.size(), 200u);
    EXPECT_EQ(name.find_first_of("/ "), std::string::npos) << name;
  }
  EXPECT_EQ(names.size(), 5u) << "replaced characters must not make two names one";
  EXPECT_EQ(cases.at(2).name, "file=a_b");
}

TEST(Placeholders, NeedBothBraces) {
  EXPECT_THAT(placeholders("a{b}{{c}}{d}"), ElementsAre("b", "d"));
  EXPECT_THROW(placeholders("a{b"), text::InputError);
  EXPECT_THROW(placeholders("a}b"), text::InputError);
}

TEST(Patterns, MatchNames) {
  EXPECT_TRUE(matches("object=mug,*", "object=mug,seed=1"));
  EXPECT_TRUE(matches("*seed=[13]", "object=mug,seed=3"));
  EXPECT_FALSE(matches("object=mug", "object=mug,seed=1"));
}

}  // namespace
}  // namespace prehend::testing
