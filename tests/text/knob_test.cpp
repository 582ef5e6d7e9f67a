#include "prehend/text/knob.h"

#include <limits>

#include <gtest/gtest.h>

namespace prehend::text {
namespace {

struct Options {
  double force = 5, share = 0.5;

  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    visit(Knob{"force", self.force, "N", 0.1, 100, "at the wrist"});
    visit(Knob{"share", self.share, "", 0, 1, "of it"});
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
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity(), -1.0, 101.0}) {
    EXPECT_NE(refusal({bad, 0.5}), "") << bad;
  }
}

TEST(Knob, IsSetAndListed) {
  Options options;
  Options::knobs(options, [](const Knob<double>& knob) { knob.value = knob.least; });
  EXPECT_EQ(options.force, 0.1);
  EXPECT_EQ(options.share, 0);
  std::vector<std::string> names;
  Options::knobs(options, ListKnobs{"arm_", &names});
  EXPECT_EQ(names, (std::vector<std::string>{"arm_force", "arm_share"}));
}

}  // namespace
}  // namespace prehend::text
