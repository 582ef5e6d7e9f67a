#include "prehend/text/knob.h"

#include <limits>

#include <gtest/gtest.h>

namespace prehend::text {
namespace {

struct Options {
  double force = 5, share = 0.5;
  int count = 3;

  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    visit(Knob{"force", self.force, "N", 0.1, 100, "at the wrist"});
    visit(Knob{"share", self.share, "", 0, 1, "of it"});
    visit(Knob{"count", self.count, "", 1, 9, "of tries"});
  }
  void validate() const { knobs(*this, CheckKnobs{"Options."}); }
};

std::string refusal(const Options& options) {
  try {
    options.validate();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Knob, IsWithinItsRange) {
  EXPECT_EQ(refusal({}), "");
  EXPECT_EQ(refusal({0.1, 0}), "");
  EXPECT_EQ(refusal({100, 1}), "");
  EXPECT_EQ(refusal({0, 0.5}), "Options.force must be within 0.1 and 100 N, not 0.000000");
  EXPECT_EQ(refusal({5, 1.5}), "Options.share must be within 0 and 1, not 1.500000");
  EXPECT_EQ(refusal({5, 0.5, 10}), "Options.count must be within 1 and 9, not 10");
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity(), -1.0, 101.0}) {
    EXPECT_NE(refusal({bad, 0.5}), "") << bad;
  }
}

TEST(Knob, IsSetAndListed) {
  Options options;
  std::map<std::string, double> given{{"force", 7}, {"count", 4}, {"forse", 1}};
  Options::knobs(options, SetKnobs{&given});
  EXPECT_EQ(options.force, 7);
  EXPECT_EQ(options.share, 0.5);
  EXPECT_EQ(options.count, 4);
  EXPECT_EQ(given, (std::map<std::string, double>{{"forse", 1}})) << "nobody took it";
  given = {{"count", 2.5}};
  EXPECT_THROW(Options::knobs(options, SetKnobs{&given}), std::invalid_argument);
  std::vector<std::string> names;
  Options::knobs(options, ListKnobs{"arm_", &names});
  EXPECT_EQ(names, (std::vector<std::string>{"arm_force", "arm_share", "arm_count"}));
}

}  // namespace
}  // namespace prehend::text
