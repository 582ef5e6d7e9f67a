#include "drivers/ft300/node/mounting.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace prehend::drivers::ft300 {
namespace {

TEST(Ft300Mounting, IdentityChangesNothing) {
  const Measurement wrench{{1, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(in_gripper_frame(wrench, mounting_from({0, 0, 0, 0, 0, 0}), false), wrench);
  EXPECT_EQ(in_gripper_frame(wrench, mounting_from({0, 0, 0, 0, 0, 0}), true),
            (Measurement{{-1, -2, -3}, {-4, -5, -6}}));
}

// A force along the sensor's x, the sensor 0.1 m behind the gripper's origin and turned by a
// quarter about z: it is along y, and turns about x by +0.1 m times it: p x F = (0, 0, -0.1) x (0,
// 1, 0).
TEST(Ft300Mounting, TurnsAndShiftsAWrench) {
  const auto X_GS = mounting_from({0, 0, -0.1, 0, 0, M_PI / 2});
  const Measurement wrench = in_gripper_frame({{1, 0, 0}, {0, 0, 0.5}}, X_GS, false);
  EXPECT_NEAR(wrench.force[0], 0, 1e-12);
  EXPECT_NEAR(wrench.force[1], 1, 1e-12);
  EXPECT_NEAR(wrench.torque[0], 0.1, 1e-12);
  EXPECT_NEAR(wrench.torque[1], 0, 1e-12);
  EXPECT_NEAR(wrench.torque[2], 0.5, 1e-12);
}

TEST(Ft300Mounting, RefusesWhatIsNoPose) {
  EXPECT_THROW(mounting_from({}), std::invalid_argument);
  EXPECT_THROW(mounting_from({0, 0, 0}), std::invalid_argument);
  EXPECT_THROW(mounting_from({0, 0, 0, 0, 0, std::numeric_limits<double>::quiet_NaN()}),
               std::invalid_argument);
}

}  // namespace
}  // namespace prehend::drivers::ft300
