#include "prehend/text/quantities.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/text/input_error.h"

namespace prehend::text {
namespace {

TEST(Quantities, HaveTheirUnit) {
  EXPECT_DOUBLE_EQ(parse_seconds("20ms"), 0.02);
  EXPECT_DOUBLE_EQ(parse_seconds("0.5 s"), 0.5);
  EXPECT_DOUBLE_EQ(parse_metres("3mm"), 0.003);
  EXPECT_DOUBLE_EQ(parse_metres("0.2 cm"), 0.002);
  EXPECT_DOUBLE_EQ(parse_seconds("0.15"), 0.15) << "as launch files and messages have it";
  EXPECT_DOUBLE_EQ(parse_metres("3e-3"), 0.003);
  EXPECT_EQ(parse_duration("10ms"), 10'000'000);
  EXPECT_EQ(parse_duration("2min"), 120'000'000'000);
  EXPECT_EQ(parse_duration("0s"), 0);
  EXPECT_EQ(parse_bytes("500MB"), 500'000'000u);
  EXPECT_EQ(parse_bytes("64KiB"), 65536u);
}

TEST(Quantities, WithoutUnitOrNumberAreRefused) {
  for (const char* bad :
       {"", "ms", "nan", "0", "-0.1", "-1ms", "0ms", "3mm", "nanms", "infs", "1 ms x"}) {
    EXPECT_THROW(parse_seconds(bad), InputError) << bad;
  }
  EXPECT_THROW(parse_metres("3ms"), InputError);
  EXPECT_THROW(parse_duration("1e30s"), InputError);
  EXPECT_THROW(parse_bytes("-1MB"), InputError);
  try {
    parse_bytes("5Mb");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("'5Mb' is no number of bytes. Write a number "
                                                   "of at least 0 with one of the units B kB MB"));
  }
}

}  // namespace
}  // namespace prehend::text
