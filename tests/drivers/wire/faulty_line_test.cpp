#include "drivers/wire/faults/faulty_line.h"

#include <gtest/gtest.h>

namespace prehend::drivers {
namespace {

using std::chrono::milliseconds;

FaultyLine<int> line_with(const LineFaults& faults, std::uint64_t seed = 1) {
  FaultyLine<int> line([](int& item, std::mt19937_64&) { item = -item; }, seed);
  line.set_faults(faults);
  return line;
}

std::vector<int> passed(FaultyLine<int>& line, int count, Time now) {
  for (int i = 1; i <= count; ++i) line.push(i, Time{});
  std::vector<int> out;
  while (const auto item = line.pop(now)) out.push_back(*item);
  return out;
}

TEST(FaultyLine, DoesNothingUnlessAsked) {
  auto line = line_with({});
  EXPECT_EQ(passed(line, 4, Time{}), (std::vector<int>{1, 2, 3, 4}));
}

TEST(FaultyLine, DropsDoublesAndCorruptsAtTheRatesAskedFor) {
  auto dropping = line_with({.dropped = 0.25});
  EXPECT_NEAR(static_cast<double>(passed(dropping, 10000, Time{}).size()), 7500, 200);
  auto doubling = line_with({.duplicated = 0.25});
  EXPECT_NEAR(static_cast<double>(passed(doubling, 10000, Time{}).size()), 12500, 200);
  auto corrupting = line_with({.corrupted = 0.25});
  const auto out = passed(corrupting, 10000, Time{});
  EXPECT_NEAR(
      static_cast<double>(std::count_if(out.begin(), out.end(), [](int i) { return i < 0; })), 2500,
      200);
}

TEST(FaultyLine, LateItemsAreOvertaken) {
  auto line = line_with({.late = 0.5, .delay = milliseconds(10)});
  const auto in_time = passed(line, 100, milliseconds(9));
  EXPECT_NEAR(static_cast<double>(in_time.size()), 50, 20);
  EXPECT_EQ(passed(line, 0, milliseconds(10)).size(), 100 - in_time.size());
}

TEST(FaultyLine, SameSeedSameFaults) {
  const LineFaults faults{.dropped = 0.2, .duplicated = 0.2, .corrupted = 0.2};
  auto a = line_with(faults, 7), b = line_with(faults, 7), c = line_with(faults, 8);
  const auto out = passed(a, 1000, Time{});
  EXPECT_EQ(out, passed(b, 1000, Time{}));
  EXPECT_NE(out, passed(c, 1000, Time{}));
}

}  // namespace
}  // namespace prehend::drivers
