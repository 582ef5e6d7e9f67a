// The driver on lines that drop, delay, double and damage messages; many starts and stops.

#include <gtest/gtest.h>
#include <malloc.h>

#include "tests/drivers/pg70/virtual_gripper.h"

namespace prehend::drivers::pg70 {
namespace {

using Kind = MotionReport::Kind;

class Pg70BadLine : public ::testing::TestWithParam<LineFaults> {};

TEST_P(Pg70BadLine, NoMotionEndsWrongly) {
  VirtualGripper g;
  ASSERT_TRUE(g.connect());
  g.to_module.set_faults(GetParam());
  g.from_module.set_faults(GetParam());
  std::mt19937_64 random(4);
  int reached = 0;
  for (int i = 0; i < 200; ++i) {
    const double opening = static_cast<double>(random() % 69) * 1e-3;
    std::uint64_t ticket = 0;
    if (!g.driver.move_to(opening, 0.08, 0, g.now, ticket).empty()) {
      g.driver.acknowledge(g.now);
      g.run(0.5);
      continue;
    }
    ASSERT_TRUE(g.run_until([&] { return g.driver.report(ticket).kind != Kind::kRunning; }, 20));
    if (g.driver.report(ticket).kind != Kind::kReached) continue;  // said so
    ++reached;
    // Nothing damaged may pass as "reached": CAN's own checksums are not emulated here, so only
    // lines that do not damage can be held to it.
    if (GetParam().corrupted > 0) continue;
    ASSERT_NEAR(g.module.motion().opening, opening, 5e-4) << i;
  }
  EXPECT_GT(reached, 40);
  EXPECT_LE(g.fastest, 0.0831);
  EXPECT_GE(g.least, -5e-4);
  EXPECT_LE(g.most, 0.0695);
  // On a good line again it comes back by itself.
  g.to_module.set_faults({});
  g.from_module.set_faults({});
  g.run(1);
  g.driver.acknowledge(g.now);
  EXPECT_TRUE(g.run_until([&] { return g.driver.reading().state >= DriverState::kStanding; }, 5));
}

INSTANTIATE_TEST_SUITE_P(
    Lines, Pg70BadLine,
    ::testing::Values(LineFaults{.dropped = 0.1}, LineFaults{.duplicated = 0.3},
                      LineFaults{.late = 0.1, .delay = std::chrono::milliseconds(60)},
                      LineFaults{.corrupted = 0.02},
                      LineFaults{.dropped = 0.05,
                                 .duplicated = 0.05,
                                 .corrupted = 0.01,
                                 .late = 0.05,
                                 .delay = std::chrono::milliseconds(30)}));

TEST(Pg70Cycles, TenThousandStartsAndStopsLeaveNothingBehind) {
  VirtualGripper g;
  std::size_t in_use = 0;
  for (int i = 0; i < 10000; ++i) {
    g.driver.connected(g.now);
    ASSERT_TRUE(g.run_until([&] { return g.driver.reading().state == DriverState::kStanding; }, 1))
        << i;
    std::uint64_t ticket = 0;
    ASSERT_EQ(g.driver.move_to(i % 2 ? 0.06 : 0.01, 0.08, 0, g.now, ticket), "");
    g.run(0.02);
    ASSERT_TRUE(g.module.is_moving());
    g.driver.link_event({LinkEvent::Kind::kClosed, "closed"}, g.now);
    ASSERT_EQ(g.driver.reading().state, DriverState::kDisconnected);
    g.sent.clear();
    g.problems.clear();
    g.notes.clear();
    if (i == 1000) in_use = mallinfo2().uordblks;
  }
  EXPECT_LT(mallinfo2().uordblks, in_use + 100000);  // bytes, after 9000 cycles more
}

}  // namespace
}  // namespace prehend::drivers::pg70
