// Ten thousand faults of the network and restarts of either side, and the arm never faster than it
// may, beyond a limit or out of its tool's box.

#include <gtest/gtest.h>

#include <iostream>
#include <random>

#include "tests/drivers/kuka_rsi/virtual_robot.h"

namespace prehend::drivers::kuka_rsi {
namespace {

TEST(RsiFaults, TenThousandMoveNothingUnsafely) {
  constexpr int kFaults = 10000;
  Limits::Options limits = wide_limits();
  limits.box = ToolBox{{-0.6, -0.9, 0.1}, {0.6, 0.9, 1.3}};
  ControllerOptions controller = controller_of_kuka();
  controller.late_limit = 30;
  VirtualRobot robot({}, controller, limits, 7);
  std::mt19937 random(42);
  const auto below = [&](unsigned count) { return static_cast<int>(random() % count); };
  robot.begin();
  int faults = 0, motions = 0, reached = 0, driver_restarts = 0, controller_restarts = 0;
  while (faults < kFaults) {
    // In one direction at a time, for one to a few telegrams, or many.
    auto& line = below(2) ? robot.out : robot.in;
    LineFaults harm;
    int lasts = below(10) == 0 ? below(40) : 1 + below(3);
    switch (below(12)) {
      case 0:
        harm.dropped = 1;
        break;
      case 1:
      case 2:
        harm.late = 1;
        harm.delay = std::chrono::milliseconds(below(60));
        break;
      case 3:
        harm.duplicated = 1;
        break;
      case 4:
      case 5:
      case 6:
        harm.corrupted = 1;
        break;
      case 7:
        if (below(8) != 0) {
          harm.dropped = 1;
        } else {
          robot.driver = nullptr;
          robot.run(0.001 * below(400));
          robot.restart_driver();
          ++driver_restarts;
        }
        break;
      case 8:
        if (below(8) != 0) {
          harm.duplicated = 1;
        } else {
          robot.controller.end("emergency stop");
          robot.run(0.2 + 0.001 * below(500));
          robot.controller.begin();
          ++controller_restarts;
        }
        break;
      default:
        harm.dropped = 0.3;
        harm.corrupted = 0.3;
        harm.duplicated = 0.3;
        break;
    }
    line.set_faults(harm);
    for (int i = 0; i < lasts; ++i) robot.step();
    line.set_faults({});
    ++faults;
    for (int i = below(40); i > 0; --i) robot.step();
    if (robot.controller.state() == Controller::State::kStopped) {
      robot.run(0.3);
      robot.controller.begin();
      robot.run(0.1);
    }
    const Snapshot& now = robot.snapshot();
    if (now.state == State::kHolding) {
      reached += now.end == Snapshot::End::kReached;
      Axes to{};
      const double shares[] = {0.3, 0.2, 0.2, 0.4, 0.3, 0.4};
      for (std::size_t k = 0; k < kAxes; ++k) {
        const double part = (static_cast<double>(random() % 2001) / 1000 - 1) * shares[k];
        to[k] = std::clamp(home_of_kuka()[k] + 3 * part, robot.limits().lower(k),
                           robot.limits().upper(k));
      }
      try {
        motions += robot.move(to, 0.6 + 0.001 * below(1500));
      } catch (const std::invalid_argument&) {  // too fast, or out of the box: nothing moves
      }
    }
    ASSERT_LE(robot.fastest, 1.0) << "after " << faults << " faults";
    ASSERT_LE(robot.beyond, 1e-5) << "after " << faults << " faults";
    ASSERT_EQ(robot.outside, 0) << "after " << faults << " faults";
  }
  std::cout << faults << " faults, " << motions << " motions begun, " << reached << " ended well, "
            << driver_restarts << " restarts of the driver, " << controller_restarts
            << " of the controller; fastest " << robot.fastest << " of the limit of speed\n";
  // The run was one: the arm moved, and both sides were restarted.
  EXPECT_GT(motions, 500);
  EXPECT_GT(reached, 50);
  EXPECT_GT(driver_restarts, 30);
  EXPECT_GT(controller_restarts, 30);
  EXPECT_GT(robot.fastest, 0.1);
}

}  // namespace
}  // namespace prehend::drivers::kuka_rsi
