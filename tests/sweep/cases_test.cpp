#include "prehend/sweep/cases.h"

#include <cmath>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/sweep/values.h"
#include "prehend/text/input_error.h"

namespace prehend::sweep {
namespace {

using text::InputError;

std::vector<std::string> all_of(const Values& values) {
  std::vector<std::string> all;
  for (std::int64_t i = 0; i < values.size(); ++i) all.push_back(values.at(i));
  return all;
}

TEST(SweepValues, StepsAreExact) {
  EXPECT_THAT(all_of(Values::steps("0.1", "0.3", "0.1")),
              ::testing::ElementsAre("0.1", "0.2", "0.3"));
  EXPECT_THAT(all_of(Values::steps("1", "-2", "-1.5")), ::testing::ElementsAre("1", "-0.5", "-2"));
  EXPECT_THAT(all_of(Values::steps("0", "1", "0.4")), ::testing::ElementsAre("0", "0.4", "0.8"));
  EXPECT_THROW(Values::steps("0", "1", "0"), InputError);
  EXPECT_THROW(Values::steps("0", "1", "-1"), InputError);
  EXPECT_THROW(Values::steps("0", "nan", "1"), InputError);
  EXPECT_THROW(Values::list({"a", "b", "a"}), InputError);
  EXPECT_THROW(Values::list({}), InputError);
}

TEST(SweepValues, SpreadsHaveBothEnds) {
  const auto equal = all_of(Values::spread(-1, 2, 4, false));
  EXPECT_THAT(equal, ::testing::ElementsAre("-1", "0", "1", "2"));
  const Values ratios = Values::spread(1e-3, 10, 5, true);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(std::log10(std::stod(ratios.at(i))), -3 + i, 1e-12) << i;
  }
  EXPECT_THROW(Values::spread(0, 1, 5, true), InputError);
  EXPECT_THROW(Values::spread(1, 1, 5, false), InputError);
  EXPECT_THROW(Values::spread(0, 1, 1, false), InputError);
}

// By the moments of each distribution.
TEST(SweepValues, DrawsAreAsTheySay) {
  constexpr int kDraws = 20000;
  const auto moments = [&](const Distribution& distribution, auto map) {
    double sum = 0, squares = 0;
    for (int i = 0; i < kDraws; ++i) {
      const double x = map(std::stod(distribution.draw(7, "x", static_cast<std::uint64_t>(i))));
      sum += x;
      squares += x * x;
    }
    const double mean = sum / kDraws;
    return std::pair(mean, squares / kDraws - mean * mean);
  };
  const auto same = [](double x) { return x; };
  using Kind = Distribution::Kind;
  auto [mean, variance] = moments({Kind::kUniform, 1, 3, {}}, same);
  EXPECT_NEAR(mean, 2, 0.02);
  EXPECT_NEAR(variance, 4.0 / 12, 0.01);
  std::tie(mean, variance) =
      moments({Kind::kLogUniform, 0.01, 100, {}}, [](double x) { return std::log10(x); });
  EXPECT_NEAR(mean, 0, 0.04);
  EXPECT_NEAR(variance, 16.0 / 12, 0.04);
  std::tie(mean, variance) = moments({Kind::kNormal, 5, 2, {}}, same);
  EXPECT_NEAR(mean, 5, 0.06);
  EXPECT_NEAR(variance, 4, 0.15);
  std::tie(mean, variance) = moments({Kind::kInteger, 1, 6, {}}, same);
  EXPECT_NEAR(mean, 3.5, 0.05);
  EXPECT_NEAR(variance, 35.0 / 12, 0.06);
}

Description two_by_three_drawn_twice() {
  Description made;
  made.program = "p";
  made.arguments = {"--a={a}", "{{{b}}}", "{x}", "{folder}/f", "{case}"};
  made.grid = {{"a", Values::list({"u/v", "w"})}, {"b", Values::steps("1", "3", "1")}};
  made.sampled = {{"x", {Distribution::Kind::kUniform, 0, 1, {}}}};
  made.sample_count = 2;
  return made;
}

TEST(SweepCases, AreEachCombinationOnceWithASafeName) {
  const Description description = two_by_three_drawn_twice();
  const Cases cases(description);
  ASSERT_EQ(cases.size(), 12);
  std::set<std::string> names;
  for (std::int64_t i = 0; i < cases.size(); ++i) {
    const Case one = cases.at(i);
    EXPECT_EQ(one.name.find('/'), std::string::npos) << one.name;
    names.insert(one.name);
  }
  EXPECT_EQ(names.size(), 12U);
  const Case last = cases.at(11);
  EXPECT_EQ(last.name, "a=w,b=3,sample=1");
  const auto words = cases.arguments(last, "/out/x");
  EXPECT_EQ(words[0], "--a=w");
  EXPECT_EQ(words[1], "{3}");
  EXPECT_EQ(words[3], "/out/x/f");
  EXPECT_EQ(words[4], last.name);
}

// More draws leave those that are there; other parameters draw other numbers.
TEST(SweepCases, DrawsDependOnTheirOwnNumberAlone) {
  const Distribution one{Distribution::Kind::kUniform, 0, 1, {}};
  EXPECT_EQ(one.draw(1, "x", 5), one.draw(1, "x", 5));
  EXPECT_NE(one.draw(1, "x", 5), one.draw(1, "x", 6));
  EXPECT_NE(one.draw(1, "x", 5), one.draw(1, "y", 5));
  EXPECT_NE(one.draw(1, "x", 5), one.draw(2, "x", 5));
}

TEST(SweepCases, PatternsMatchAsShellsHaveThem) {
  EXPECT_TRUE(matches("a=w,*", "a=w,b=3"));
  EXPECT_TRUE(matches("a=?,b=[12]", "a=u,b=2"));
  EXPECT_FALSE(matches("a=?,b=[12]", "a=u,b=3"));
  EXPECT_NE(file_safe("u/v"), file_safe("u:v"));
}

}  // namespace
}  // namespace prehend::sweep
