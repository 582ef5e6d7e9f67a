// Values of grids and draws of samples.

#include "prehend/sweep/values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "prehend/text/input_error.h"

namespace prehend::testing {
namespace {

using sweep::Decimal;
using sweep::Distribution;
using sweep::Values;
using ::testing::ElementsAre;

std::vector<std::string> all(const Values& values) {
  std::vector<std::string> words;
  for (std::int64_t i = 0; i < values.size(); ++i) words.push_back(values.at(i));
  return words;
}

TEST(Values, StepsAreExact) {
  // In doubles 0.1 + 2 * 0.1 is 0.30000000000000004.
  EXPECT_THAT(all(Values::steps("0.1", "0.3", "0.1")), ElementsAre("0.1", "0.2", "0.3"));
  EXPECT_THAT(all(Values::steps("-1", "1", "0.5")), ElementsAre("-1", "-0.5", "0", "0.5", "1"));
  EXPECT_THAT(all(Values::steps("10", "0", "-4")), ElementsAre("10", "6", "2"));
  EXPECT_THAT(all(Values::steps("1e-3", "3e-3", "1e-3")), ElementsAre("0.001", "0.002", "0.003"));
  EXPECT_THAT(all(Values::steps("5", "5", "1")), ElementsAre("5"));
  EXPECT_EQ(Values::steps("1", "10000000", "1").size(), 10000000);
}

TEST(Values, SpreadOnesMeetBothEnds) {
  EXPECT_THAT(all(Values::spread(0, 1, 5, false)), ElementsAre("0", "0.25", "0.5", "0.75", "1"));
  const Values decades = Values::spread(0.001, 1000, 7, true);
  EXPECT_EQ(decades.at(0), "0.001");
  EXPECT_EQ(decades.at(6), "1000");
  for (int i = 0; i < 7; ++i) {
    const double value = std::stod(decades.at(i));
    EXPECT_NEAR(value / std::pow(10, i - 3), 1, 1e-14);
  }
}

TEST(Values, RefusesWhatIsNoRange) {
  using text::InputError;
  EXPECT_THROW(Values::list({}), InputError);
  EXPECT_THROW(Values::list({"a", "b", "a"}), InputError);
  EXPECT_THROW(Values::steps("1", "2", "0"), InputError);
  EXPECT_THROW(Values::steps("1", "2", "-1"), InputError);
  EXPECT_THROW(Values::steps("a", "2", "1"), InputError);
  EXPECT_THROW(Values::steps("123456789012345678", "2", "1"), InputError);
  EXPECT_THROW(Values::steps("1e-15", "123456", "1"), InputError);
  EXPECT_THROW(Values::spread(1, 1, 5, false), InputError);
  EXPECT_THROW(Values::spread(0, 1, 1, false), InputError);
  EXPECT_THROW(Values::spread(0, 1, 5, true), InputError);
}

TEST(Decimals, AreReadAsWritten) {
  EXPECT_EQ(Decimal::parse("0.250").digits, 250);
  EXPECT_EQ(Decimal::parse("0.250").places, 3);
  EXPECT_EQ(Decimal::parse("-2e3").digits, -2000);
  EXPECT_EQ(Decimal::parse("2e3").places, 0);
  EXPECT_EQ(Decimal::parse("0").digits, 0);
  EXPECT_DOUBLE_EQ(Decimal::parse("1.5e-3").value(), 1.5e-3);
}

struct Moments {
  double mean = 0, deviation = 0, least = 1e300, most = -1e300;
};

Moments moments(const Distribution& distribution, bool logarithms = false) {
  constexpr int kDraws = 20000;
  Moments made;
  double squares = 0;
  for (int i = 0; i < kDraws; ++i) {
    double value = std::stod(distribution.draw(7, "mass", i));
    if (logarithms) value = std::log(value);
    made.mean += value / kDraws;
    squares += value * value / kDraws;
    made.least = std::min(made.least, value);
    made.most = std::max(made.most, value);
  }
  made.deviation = std::sqrt(squares - made.mean * made.mean);
  return made;
}

// Against the closed forms of mean and standard deviation, within five standard errors.
TEST(Draws, HaveTheirDistributions) {
  using Kind = Distribution::Kind;
  const Moments uniform = moments({Kind::kUniform, -1, 3, {}});
  EXPECT_NEAR(uniform.mean, 1, 0.05);
  EXPECT_NEAR(uniform.deviation, 4 / std::sqrt(12), 0.02);
  EXPECT_GE(uniform.least, -1);
  EXPECT_LT(uniform.most, 3);
  const Moments logarithmic = moments({Kind::kLogUniform, 0.01, 100, {}}, true);
  EXPECT_NEAR(logarithmic.mean, 0, 0.1);
  EXPECT_NEAR(logarithmic.deviation, std::log(1e4) / std::sqrt(12), 0.05);
  const Moments normal = moments({Kind::kNormal, 5, 2, {}});
  EXPECT_NEAR(normal.mean, 5, 0.08);
  EXPECT_NEAR(normal.deviation, 2, 0.06);
  const Moments die = moments({Kind::kInteger, 1, 6, {}});
  EXPECT_NEAR(die.mean, 3.5, 0.07);
  EXPECT_NEAR(die.deviation, std::sqrt(35.0 / 12), 0.04);
  EXPECT_EQ(die.least, 1);
  EXPECT_EQ(die.most, 6);
}

TEST(Draws, DependOnSeedNameAndNumberAlone) {
  const Distribution one{Distribution::Kind::kUniform, 0, 1, {}};
  EXPECT_EQ(one.draw(1, "mass", 3), one.draw(1, "mass", 3));
  EXPECT_NE(one.draw(1, "mass", 3), one.draw(1, "mass", 4));
  EXPECT_NE(one.draw(1, "mass", 3), one.draw(2, "mass", 3));
  EXPECT_NE(one.draw(1, "mass", 3), one.draw(1, "friction", 3));
  const Distribution choice{Distribution::Kind::kChoice, 0, 1, {"a", "b", "c"}};
  int each[3] = {};
  for (int i = 0; i < 3000; ++i) ++each[choice.draw(1, "hand", i)[0] - 'a'];
  for (const int count : each) EXPECT_NEAR(count, 1000, 130);
}

}  // namespace
}  // namespace prehend::testing
