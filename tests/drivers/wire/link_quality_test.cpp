#include "drivers/wire/health/link_quality.h"

#include <gtest/gtest.h>

namespace prehend::drivers {
namespace {

// Samples twice a second of a line that brings `good` and harms `harmed` messages in each half.
class SampledLine {
 public:
  void run(double seconds, std::uint64_t good, std::uint64_t harmed, double rate = 0) {
    for (double t = 0; t < seconds; t += 0.5) {
      good_ += good;
      harmed_ += harmed;
      now_ += to_time(0.5);
      quality.sample(good_, harmed_, rate, now_);
    }
  }
  LinkQuality quality;

 private:
  std::uint64_t good_ = 1000, harmed_ = 500;  // what was before does not count
  Time now_ = to_time(1e4);
};

TEST(LinkQuality, SoundLineIsNoProblem) {
  SampledLine line;
  EXPECT_EQ(line.quality.problem(), "");
  line.run(20, 25, 0, 50);
  EXPECT_EQ(line.quality.problem(), "");
  EXPECT_NEAR(line.quality.rate(), 50, 1e-9);
  EXPECT_EQ(line.quality.harmed_part(), 0);
}

TEST(LinkQuality, DamagedMessagesAreToldAndForgotten) {
  SampledLine line;
  line.run(5, 25, 0);
  line.run(5, 22, 3);
  EXPECT_NEAR(line.quality.harmed_part(), 0.12, 0.01);
  EXPECT_NE(line.quality.problem().find("12 % of its messages"), std::string::npos)
      << line.quality.problem();
  line.run(6, 25, 0);
  EXPECT_EQ(line.quality.problem(), "");
}

TEST(LinkQuality, OneMessageMayComeToHarm) {
  SampledLine line;
  line.run(2, 10, 0);
  line.run(0.5, 10, 2);
  EXPECT_EQ(line.quality.problem(), "");
}

TEST(LinkQuality, MissingMessagesAreTold) {
  SampledLine line;
  line.run(1, 15, 0, 50);
  EXPECT_EQ(line.quality.problem(), "");  // too early
  line.run(4, 15, 0, 50);
  EXPECT_NE(line.quality.problem().find("only 30 of 50 messages a second"), std::string::npos);
  line.run(6, 25, 0, 50);
  EXPECT_EQ(line.quality.problem(), "");
}

TEST(LinkQuality, AnAbsentDeviceIsNoBadLine) {
  SampledLine line;
  line.run(5, 0, 5, 50);
  EXPECT_NE(line.quality.problem(), "");
  line.quality.restart();
  EXPECT_EQ(line.quality.problem(), "");
  line.run(5, 25, 0, 50);
  EXPECT_EQ(line.quality.problem(), "");
}

}  // namespace
}  // namespace prehend::drivers
