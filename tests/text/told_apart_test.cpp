#include "prehend/text/told_apart.h"

#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

namespace prehend::text {
namespace {

void expect_pair(const NumberPair& pair, const std::string& first, const std::string& second) {
  EXPECT_EQ(pair.first, first);
  EXPECT_EQ(pair.second, second);
}

// "30.0 mm > 30.0 mm" was said of why a grasp was refused.
TEST(ToldApart, TakesTheDigitsThatDiffer) {
  expect_pair(told_apart(74, 69, 1), "74.0", "69.0");
  expect_pair(told_apart(30.02, 30, 1), "30.02", "30.00");
  expect_pair(told_apart(30.0004, 30, 0), "30.0004", "30.0000");
  expect_pair(told_apart(-3.2, 4, 1), "-3.2", "4.0");
  expect_pair(told_apart(-0.04, 0, 1), "-0.04", "0.00");
}

TEST(ToldApart, EqualNumbersReadAlike) {
  expect_pair(told_apart(30, 30, 1), "30.0", "30.0");
  expect_pair(told_apart(30, 30 + 1e-14, 1), "30.0", "30.0");
  expect_pair(told_apart(NAN, NAN, 1), "nan", "nan");
}

TEST(ToldApart, ReadInTheOrderTheyHave) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-9, 1), value(-100, 100);
  for (int i = 0; i < 100000; ++i) {
    const double first = value(random), second = first + std::pow(10, exponent(random));
    const NumberPair pair = told_apart(first, second, 1);
    EXPECT_LT(std::stod(pair.first), std::stod(pair.second)) << first << ' ' << second;
  }
}

}  // namespace
}  // namespace prehend::text
