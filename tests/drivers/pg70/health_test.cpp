// What `prehend doctor` says of a gripper follows from its state.

#include "drivers/pg70/driver/health.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/drivers/pg70/virtual_gripper.h"

namespace prehend::drivers::pg70 {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Level = Health::Level;

Situation situation_of(const VirtualGripper& g) {
  Situation s;
  s.reading = g.driver.reading();
  s.obstacle = g.driver.obstacle();
  s.address.line = "can0";
  return s;
}

TEST(Pg70Health, StandingIsWell) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  EXPECT_EQ(health_of(situation_of(g)), (Health{Level::kOk, "standing"}));
}

// It read "ok: standing".
TEST(Pg70Health, ErrorIsAStateAndItsPersistingCauseIsAWarning) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  g.module.fail(ErrorCode::kCurrent, true, g.now);
  g.run(0.1);
  const Health fault = health_of(situation_of(g));
  EXPECT_EQ(fault.level, Level::kError);
  EXPECT_THAT(fault.words, HasSubstr("ERROR CURRENT"));
  EXPECT_THAT(fault.words, HasSubstr("/gripper/acknowledge"));
  g.driver.acknowledge(g.now);
  g.run(0.1);
  const Health warning = health_of(situation_of(g));
  EXPECT_EQ(warning.level, Level::kWarning);
  EXPECT_THAT(warning.words, HasSubstr("standing; the cause persists of ERROR CURRENT"));
  g.module.mend(g.now);
  g.run(0.1);
  EXPECT_EQ(health_of(situation_of(g)).level, Level::kOk);
}

// It read "check its supply".
TEST(Pg70Health, UnitSystemOfDegreesIsNamed) {
  ModuleOptions degrees;
  degrees.unit = UnitSystem::kDegree;
  VirtualGripper g({}, degrees);
  EXPECT_FALSE(g.connect());
  Situation s = situation_of(g);
  s.connecting = 5;
  const Health health = health_of(s);
  EXPECT_EQ(health.level, Level::kError);
  EXPECT_THAT(health.words, HasSubstr("unit system 4 is no length"));
  EXPECT_THAT(health.words, Not(HasSubstr("supply")));
  std::uint64_t ticket = 0;
  EXPECT_THAT(g.driver.move_to(0.02, 0.05, 0, g.now, ticket), HasSubstr("unit system 4"));
}

TEST(Pg70Health, ModuleThatDoesNotAnswerIsNamedAfterASecond) {
  Situation s;
  s.reading.state = DriverState::kConnecting;
  s.address = {"can0", 0, 13};
  s.connecting = 0.5;
  EXPECT_EQ(health_of(s).level, Level::kOk);
  s.connecting = 2;
  EXPECT_EQ(health_of(s).level, Level::kError);
  EXPECT_THAT(health_of(s).words, HasSubstr("module 13 does not answer on can0"));
}

TEST(Pg70Health, LineGuardianAndLossCount) {
  Situation s;
  EXPECT_EQ(health_of(s).level, Level::kOk);  // nothing is known yet
  s.line_problem = "can0 went down";
  EXPECT_EQ(health_of(s), (Health{Level::kError, "can0 went down"}));
  s.reading.state = DriverState::kLost;
  EXPECT_EQ(health_of(s).level, Level::kError);
  s.reading.state = DriverState::kHolding;
  s.link_problem = "the line is bad";
  s.guard_problem = "no guardian";
  EXPECT_EQ(health_of(s), (Health{Level::kWarning, "holding; the line is bad; no guardian"}));
  s.reading.state = DriverState::kUnreferenced;
  EXPECT_EQ(health_of(s).level, Level::kWarning);
}

}  // namespace
}  // namespace prehend::drivers::pg70
