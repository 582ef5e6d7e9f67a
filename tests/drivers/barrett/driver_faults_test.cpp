// The driver on buses that lose, delay and double what they carry; cables that are pulled and
// plugged, hands and drivers that start anew. What counts is what the emulated hand does, not what
// it was told. Damage: a CAN controller throws damaged frames away, so that they are lost; what the
// host hears is damaged nevertheless, as the line of a serial adapter may do.

#include <gtest/gtest.h>

#include "tests/drivers/barrett/virtual_hand.h"

namespace prehend::drivers::barrett {
namespace {

using Kind = MotionReport::Kind;

constexpr double kMostSpeed = 0.6, kMostTorque = 500;  // rad/s, MT, of all commands

AxisValues random_position(const AxisValues& here, std::mt19937_64& random) {
  std::uniform_real_distribution<double> step(-0.4, 0.4);
  const Limits limits = bh8_limits();
  AxisValues position{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    position[i] = std::clamp(here[i] + step(random), limits.lower[i], limits.upper[i]);
  }
  return position;
}

TEST(BarrettTenThousandFaults, NoUnsafeMotion) {
  DriverOptions options;
  options.limits.max_speed.fill(kMostSpeed);
  options.limits.max_current.fill(kMostTorque);
  HandOptions of_hand;
  of_hand.wake_time = 0.1;
  of_hand.self_start = 0.3;
  VirtualHand g(options, of_hand);
  ASSERT_TRUE(g.begin());
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> share(0, 1);
  const auto faults = [&](bool may_damage) {
    const double most = 0.2 * std::pow(share(random), 3);  // from hardly any to every fifth frame
    return LineFaults{.dropped = most * share(random),
                      .duplicated = most * share(random),
                      .corrupted = may_damage ? most * share(random) : 0,
                      .late = most * share(random),
                      .delay = to_time(0.4 * share(random))};
  };
  std::uint64_t harmed = 0, motions = 0, reached = 0, replugs = 0, reboots = 0, restarts = 0;
  const std::uint64_t until = 10000;
  const Limits limits = bh8_limits();
  int rounds = 0;
  while (harmed < until || rounds < 600) {
    ++rounds;
    g.to_hand.set_faults(faults(false));
    g.from_hand.set_faults(faults(true));
    const std::uint64_t before = g.to_hand.harmed() + g.from_hand.harmed();
    std::uint64_t ticket = 0;
    if (g.driver.reading().state == DriverState::kUninitialised) {
      g.driver.initialise(g.now, ticket);
      g.run(6 * share(random));
    }
    const HandGoal goal =
        g.goal(random_position(g.hand.motion().position, random),
               kMostSpeed * (0.3 + 0.7 * share(random)), kMostTorque * (0.3 + 0.7 * share(random)));
    if (share(random) < 0.3) g.plant.put_object(random() % 3, 2 * share(random));
    const std::string refusal = g.driver.move_to(goal, g.now, ticket);
    motions += refusal.empty();
    g.run(0.7 * share(random));
    switch (random() % 12) {
      case 0:
      case 1:
        g.driver.disconnected("pulled");
        g.run(0.3 * share(random));
        g.driver.connected(g.now);
        ++replugs;
        break;
      case 2:
        g.hand.reboot(g.now);
        ++reboots;
        break;
      case 3:
        g.begin_driver_anew();
        ++restarts;
        break;
      case 4:
        g.driver.stop(g.now);
        break;
      default:
        break;
    }
    g.run(2 * share(random));
    if (refusal.empty() && g.driver.report(ticket).kind == Kind::kReached) {
      ++reached;
      for (std::size_t i = 0; i < kAxes; ++i) {
        ASSERT_NEAR(g.hand.motion().position[i], goal.position[i], 0.05) << i << " " << rounds;
      }
    }
    harmed += g.to_hand.harmed() + g.from_hand.harmed() - before;
    g.plant.remove_objects();
    g.sent.clear();
    g.images.clear();
    if (HasFailure()) break;
  }
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_LE(g.fastest[i], kMostSpeed * 1.01) << i;
    EXPECT_LE(g.strongest[i], kMostTorque * 1.001) << i;
    EXPECT_GE(g.least[i], limits.lower[i] - 1e-3) << i;
    EXPECT_LE(g.most[i], limits.upper[i] + 0.02) << i;
  }
  RecordProperty("motions", std::to_string(motions));
  RecordProperty("reached", std::to_string(reached));
  RecordProperty("faults", std::to_string(harmed));
  EXPECT_GT(motions, 100u);
  EXPECT_GT(reached, 30u);
  EXPECT_GT(replugs, 50u);
  EXPECT_GT(reboots, 20u);
  EXPECT_GT(restarts, 20u);
  // On a good bus again it comes back by itself, and stands.
  g.to_hand.set_faults({});
  g.from_hand.set_faults({});
  g.run(4);
  EXPECT_GE(g.driver.reading().state, DriverState::kUninitialised);
  const std::uint64_t moves = g.hand.moves();
  g.run(1);
  EXPECT_EQ(g.hand.moves(), moves);
  EXPECT_FALSE(g.hand.is_moving());
}

}  // namespace
}  // namespace prehend::drivers::barrett
