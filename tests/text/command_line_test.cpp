#include "prehend/text/command_line.h"

#include <array>

#include <gtest/gtest.h>

namespace prehend::text {
namespace {

// What the check says of a word; "": it accepts it.
std::string said(const CLI::Validator& check, std::string word) { return check(word); }

TEST(CommandLine, RangesHaveOnlyNumbers) {
  const CLI::Validator share = in_range(0.0, 1.0);
  for (const char* good : {"0", "1", "0.5", "1e-3"}) EXPECT_EQ(said(share, good), "") << good;
  for (const char* bad : {"nan", "-nan", "inf", "1.1", "-0.1", "half", ""}) {
    EXPECT_EQ(said(share, bad), "'" + std::string(bad) + "' is no number in [0 - 1]");
  }
  const CLI::Validator count = in_range(1, 16);
  EXPECT_EQ(said(count, "16"), "");
  for (const char* bad : {"0", "17", "1.5", "nan", "99999999999999999999"}) {
    EXPECT_NE(said(count, bad), "") << bad;
  }
}

TEST(CommandLine, NumbersAboveZeroAreFinite) {
  EXPECT_EQ(said(above_zero(), "1e300"), "");
  EXPECT_EQ(said(above_zero(true), "0"), "");
  for (const char* bad : {"0", "-1", "nan", "inf", "1e999", "150ms"}) {
    EXPECT_EQ(said(above_zero(), bad), "'" + std::string(bad) + "' is no number above 0");
  }
  EXPECT_NE(said(above_zero(true), "-1e-9"), "");
}

TEST(CommandLine, WrongUseEndsWithTwo) {
  const auto code_of = [](std::string word) {
    CLI::App app;
    double value = 0;
    app.add_option("--value", value)->check(above_zero());
    std::string name = "program";
    std::array<char*, 2> words{name.data(), word.data()};
    return parse_command_line(app, 2, words.data());
  };
  EXPECT_EQ(code_of("--value=3"), std::nullopt);
  EXPECT_EQ(code_of("--help"), 0);
  EXPECT_EQ(code_of("--value=nan"), 2);
  EXPECT_EQ(code_of("--other"), 2);
}

}  // namespace
}  // namespace prehend::text
