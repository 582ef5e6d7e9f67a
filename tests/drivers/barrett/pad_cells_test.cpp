// Where a puck's 24 cells are in a pad's grid.

#include <gtest/gtest.h>

#include <numeric>

#include "drivers/barrett/node/hand_axes.h"
#include "drivers/barrett/node/pad_cells.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/platform.h"

namespace prehend::drivers::barrett {
namespace {

class BarrettPads : public ::testing::Test {
 protected:
  robot::Platform platform_ = robot::read_platform("config/robots/pa10_barrett.yaml");
  Cells cells_ = [] {
    Cells cells{};
    std::iota(cells.begin(), cells.end(), std::uint16_t{1});
    return cells;
  }();
};

TEST_F(BarrettPads, FingertipIsRowByRowAndPalmLacksItsCorners) {
  const PadCells tip(platform_.hand, "fingertip_2", {});
  const msgs::TactileFrame frame = tip.message(cells_, 7);
  EXPECT_EQ(frame.header().stamp(), 7);
  EXPECT_EQ(frame.header().frame_id(), "fingertip_2");
  EXPECT_EQ(frame.rows(), 8u);
  EXPECT_EQ(frame.columns(), 3u);
  ASSERT_EQ(frame.intensity_size(), 24);
  for (int i = 0; i < 24; ++i) EXPECT_EQ(frame.intensity(i), static_cast<unsigned>(i + 1));
  EXPECT_NEAR(frame.sum(), 300 * 0.000977, 1e-9);
  EXPECT_EQ(tip.cells(frame), cells_);
  const PadCells palm(platform_.hand, "palm", {});
  const msgs::TactileFrame wide = palm.message(cells_, 0);
  ASSERT_EQ(wide.intensity_size(), 28);
  for (const int corner : {0, 3, 24, 27}) EXPECT_EQ(wide.intensity(corner), 0u);
  EXPECT_EQ(wide.intensity(1), 1u);
  EXPECT_EQ(wide.intensity(4), 3u);
  EXPECT_EQ(wide.intensity(26), 24u);
  EXPECT_EQ(palm.cells(wide), cells_);
}

TEST_F(BarrettPads, AnotherOrderIsTakenAndABadOneRefused) {
  std::vector<std::size_t> reversed(kCells);
  for (std::size_t i = 0; i < kCells; ++i) reversed[i] = kCells - 1 - i;
  const PadCells tip(platform_.hand, "fingertip_1", reversed);
  EXPECT_EQ(tip.message(cells_, 0).intensity(23), 1u);
  EXPECT_EQ(tip.cells(tip.message(cells_, 0)), cells_);
  EXPECT_THROW(PadCells(platform_.hand, "fingertip_1", {0, 1}), geometry::InputError);
  EXPECT_THROW(PadCells(platform_.hand, "fingertip_1", std::vector<std::size_t>(24, 3)),
               geometry::InputError);
  EXPECT_THROW(PadCells(platform_.hand, "fingertip_9", {}), geometry::InputError);
  // Frames that lack cells give none.
  EXPECT_EQ(tip.cells({}), Cells{});
}

// What clutches do to the joints' positions is what libbarrett computes of both encoders.
TEST_F(BarrettPads, OuterJointsAreThoseOfBothEncoders) {
  const HandAxes axes = hand_axes(platform_, kBh8Axes, Model::kBh8_280, {}, 2200);
  ASSERT_EQ(axes.followers().size(), 3u);
  const Gearing gearing;
  for (const HandAxes::Follower& follower : axes.followers()) {
    const double motor = 1.5, inner = 0.9;  // rad: the clutch is open
    // outer = P (1/125 + 1/375) - inner
    const double turns = motor * 125;
    EXPECT_NEAR(follower.position(motor, inner), turns * (1.0 / 125 + 1.0 / 375) - inner, 1e-9);
    EXPECT_NEAR(follower.position(0.6, 0.6), 0.2, 1e-9);
    EXPECT_NEAR(follower.motor(inner, follower.position(motor, inner)), motor, 1e-9);
    EXPECT_EQ(axes.moving_names()[follower.place], "hand_" + follower.joint);
  }
  const std::vector<double> motors{1.5, 0.6, 0.3, 1}, inner{0.9, 0.6, 0.3, 1};
  const auto names = axes.moving_names();
  const auto values = axes.moving_values(motors, inner);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == "hand_finger_1_inner") EXPECT_NEAR(values[i], 0.9, 1e-9);
    if (names[i] == "hand_finger_1_outer") EXPECT_NEAR(values[i], 1.1, 1e-9);
    if (names[i] == "hand_finger_2_outer") EXPECT_NEAR(values[i], 0.2, 1e-9);
    if (names[i] == "hand_finger_2_spread") EXPECT_NEAR(values[i], 1, 1e-9);
  }
}

}  // namespace
}  // namespace prehend::drivers::barrett
