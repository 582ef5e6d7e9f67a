// The driver on lines that lose, delay, double, cut and damage what they carry; lines that are
// pulled and plugged, hands and drivers that start anew. What counts is what the emulated hand
// does, not what it was told.

#include <gtest/gtest.h>

#include "tests/drivers/sdh/virtual_hand.h"

namespace prehend::drivers::sdh {
namespace {

using Kind = MotionReport::Kind;

constexpr double kMostSpeed = 0.4, kMostCurrent = 0.3;  // rad/s, A, of all commands

// Within 0.4 rad of where it is, so that some motions end before they are harmed.
AxisValues random_position(const AxisValues& here, std::mt19937_64& random) {
  std::uniform_real_distribution<double> step(-0.4, 0.4);
  const Limits limits = sdh2_limits();
  AxisValues position{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    position[i] = std::clamp(here[i] + step(random), limits.lower[i], limits.upper[i]);
  }
  return position;
}

void expect_safe(const VirtualHand& g) {
  const Limits limits = sdh2_limits();
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_LE(g.fastest[i], kMostSpeed * 1.01) << i;
    EXPECT_LE(g.strongest[i], kMostCurrent * 1.001) << i;
    EXPECT_GE(g.least[i], limits.lower[i] - 1e-3) << i;
    EXPECT_LE(g.most[i], limits.upper[i] + 1e-3) << i;
  }
}

struct Case {
  const char* name;
  bool binary;
};
class SdhTenThousandFaults : public ::testing::TestWithParam<Case> {};

TEST_P(SdhTenThousandFaults, NoUnsafeMotion) {
  DriverOptions options;
  options.binary = GetParam().binary;
  HandOptions of_hand;
  of_hand.boot_time = 0.7;  // s: shorter than real ones, to have more of them
  VirtualHand g(options, of_hand);
  ASSERT_TRUE(g.connect());
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> share(0, 1);
  const auto faults = [&] {
    const double most = 0.2 * std::pow(share(random), 3);  // from hardly any to every fifth block
    return LineFaults{.dropped = most * share(random),
                      .duplicated = most * share(random),
                      .corrupted = most * share(random),
                      .late = most * share(random),
                      .delay = to_time(0.4 * share(random))};
  };
  std::uint64_t harmed = 0, reached = 0, replugs = 0, reboots = 0, restarts = 0;
  const std::uint64_t until = 10000;
  while (harmed < until) {
    g.to_hand.set_faults(faults());
    g.from_hand.set_faults(faults());
    const std::uint64_t before = g.to_hand.harmed() + g.from_hand.harmed();
    HandGoal goal = g.goal(random_position(g.hand.motion().position, random),
                           kMostSpeed * (0.3 + 0.7 * share(random)),
                           kMostCurrent * (0.3 + 0.7 * share(random)));
    if (share(random) < 0.3) g.plant.put_object(1 + random() % 6, share(random) - 0.5);
    std::uint64_t ticket = 0;
    const std::string refusal = g.driver.move_to(goal, g.now, ticket);
    g.run(0.7 * share(random));
    switch (random() % 8) {
      case 0:
        g.driver.disconnected("pulled");
        g.run(0.3 * share(random));
        g.driver.connected(g.now);
        ++replugs;
        break;
      case 1:
        g.hand.reboot(g.now);
        ++reboots;
        break;
      case 2:
        g.begin_driver_anew();
        ++restarts;
        break;
      case 3:
        g.driver.stop(g.now);
        break;
      default:
        break;
    }
    g.run(3 * share(random));
    if (refusal.empty() && g.driver.report(ticket).kind == Kind::kReached) {
      ++reached;
      for (std::size_t i = 0; i < kAxes; ++i) {
        ASSERT_NEAR(g.hand.motion().position[i], goal.position[i], 0.03) << i;
      }
    }
    harmed += g.to_hand.harmed() + g.from_hand.harmed() - before;
    g.plant.remove_object();
    g.sent.clear();
    if (HasFailure()) break;
  }
  expect_safe(g);
  EXPECT_GT(reached, 50u);
  EXPECT_GT(replugs, 100u);
  EXPECT_GT(reboots, 100u);
  EXPECT_GT(restarts, 100u);
  RecordProperty("motions", std::to_string(g.hand.moves()));
  // On a good line again it comes back by itself, and stands.
  g.to_hand.set_faults({});
  g.from_hand.set_faults({});
  g.run(4);
  EXPECT_GE(g.driver.reading().state, DriverState::kOff);
  const std::uint64_t moves = g.hand.moves();
  g.run(1);
  EXPECT_EQ(g.hand.moves(), moves);
  EXPECT_FALSE(g.hand.is_moving());
  EXPECT_EQ(
      g.move(g.goal(random_position(g.hand.motion().position, random), kMostSpeed, kMostCurrent))
          .kind,
      Kind::kReached);
}

INSTANTIATE_TEST_SUITE_P(Forms, SdhTenThousandFaults,
                         ::testing::Values(Case{"binary", true}, Case{"text", false}),
                         [](const auto& form) { return form.param.name; });

}  // namespace
}  // namespace prehend::drivers::sdh
