#include "msgs/convert/touch.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "msgs/convert/pad_touch.h"
#include "msgs/convert/tactile_cells.h"

namespace prehend::convert {
namespace {

TEST(Touch, OfThePadsThatFeelSomethingWithTheirImages) {
  const robot::HandModel hand = robot::read_hand_model("config/robots/sdh2.yaml");
  planning::PredictedTouch touch;
  touch.outcome = planning::TouchOutcome::kPredicted;
  for (const robot::HandPad& pad : hand.pads) {
    planning::PredictedPad felt;
    felt.name = pad.name;
    felt.rows = pad.model.rows;
    felt.columns = pad.model.columns;
    felt.counts.assign(static_cast<std::size_t>(felt.rows * felt.columns), 0);
    touch.pads.push_back(felt);
  }
  planning::PredictedPad& one = touch.pads[3];
  one.counts[7] = 200;
  one.sum = 0.14;
  one.area = 1.2e-5;
  one.center_P = {0.002, -0.01, -0.003};
  touch.stopped = Eigen::VectorXd::LinSpaced(hand.size(), 0, 0.6);
  msgs::PredictedPercepts percepts;
  percepts.set_lifted_mass(0.4);
  add_touch(touch, hand, &percepts);
  EXPECT_EQ(percepts.lifted_mass(), 0.4);
  EXPECT_EQ(percepts.not_predicted(), "");
  ASSERT_EQ(percepts.pads_size(), 1);
  const msgs::TactileFrame& image = percepts.pads(0).image();
  EXPECT_EQ(image.header().frame_id(), hand.pads[3].name);
  EXPECT_EQ(image.intensity_size(), static_cast<int>(image.rows() * image.columns()));
  EXPECT_EQ(image.intensity(7), 200u);
  EXPECT_EQ(image.texel_width(), hand.pads[3].model.texel_pitch);
  EXPECT_EQ(image.sum(), 0.14);
  EXPECT_EQ(percepts.pads(0).contact_area(), 1.2e-5);
  EXPECT_EQ(percepts.pads(0).center().y(), -0.01);
  EXPECT_EQ(percepts.pads(0).center().z(), -0.003) << "of a curved pad";
  ASSERT_EQ(percepts.stop_position_size(), hand.size());
  EXPECT_EQ(percepts.stop_position(hand.size() - 1), 0.6);
}

TEST(Touch, OrWhyItIsNotKnown) {
  planning::PredictedTouch touch;
  touch.outcome = planning::TouchOutcome::kMissed;
  touch.problem = "the fingers close beside the object";
  msgs::PredictedPercepts percepts;
  add_touch(touch, robot::read_hand_model("config/robots/sdh2.yaml"), &percepts);
  EXPECT_EQ(percepts.not_predicted(), touch.problem);
  EXPECT_EQ(percepts.pads_size(), 0);
  EXPECT_EQ(percepts.stop_position_size(), 0);
}

// What a consumer needs for the centre of pressure: by the message alone, of a half-ball that is
// pressed evenly it lies half a radius up (Archimedes: each slice has the same area).
TEST(Touch, ACurvedPadsCellsTellTheCentreOfPressure) {
  const robot::HandModel hand = robot::read_hand_model("config/robots/ball_probe.yaml");
  const msgs::TactileCells message = cells_message(hand);
  ASSERT_EQ(message.pads_size(), 1);
  const msgs::PadCells& pad = message.pads(0);
  EXPECT_EQ(pad.name(), "tip");
  EXPECT_EQ(pad.link(), "tip");
  EXPECT_EQ(pad.thickness(), 0.003);
  const int cells = static_cast<int>(pad.rows() * pad.columns());
  ASSERT_EQ(pad.area_size(), cells);
  ASSERT_EQ(pad.position_size(), 3 * cells);
  ASSERT_EQ(pad.normal_size(), 3 * cells);
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(), normal = centre;
  double area = 0;
  for (int i = 0; i < cells; ++i) {
    for (int k = 0; k < 3; ++k) {
      centre[k] += pad.area(i) * pad.position(3 * i + k);
      normal[k] += pad.area(i) * pad.normal(3 * i + k);
    }
    area += pad.area(i);
  }
  EXPECT_LT((centre / area - Eigen::Vector3d(0, 0, 0.005)).norm(), 1e-4);
  EXPECT_GT(normal.normalized().z(), 1 - 1e-9);
  const msgs::TactileCells barrett =
      cells_message(robot::read_hand_model("config/robots/bh8.yaml"));
  for (const msgs::PadCells& one : barrett.pads()) {
    int there = 0;
    for (const double of : one.area()) there += of > 0;
    EXPECT_EQ(there, 24) << one.name();
  }
}

// The half-ball pressed 1 mm into a plane from several sides: the plane's normal, and that it is
// flat, are felt from the frame alone.
TEST(PadTouch, AHalfBallFeelsThePlaneThatItIsPressedOn) {
  const robot::HandModel hand = robot::read_hand_model("config/robots/ball_probe.yaml");
  const robot::HandPad& pad = hand.pads.at(0);
  const contact::PadLayout& layout = *pad.layout;
  msgs::TactileFrame frame;
  frame.set_rows(1);
  frame.set_columns(static_cast<std::uint32_t>(layout.size()));
  frame.set_newton_per_count(1e-6);
  frame.set_full_scale(100'000'000);
  for (const Eigen::Vector3d& from :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0.4, -0.3, 1), Eigen::Vector3d(-1, 0.2, 0.7)}) {
    const Eigen::Vector3d direction = from.normalized();
    double highest = 0;
    for (std::size_t i = 0; i < layout.size(); ++i) {
      if (layout.scale[i] <= 0) continue;
      highest = std::max(highest, direction.dot(layout.position(i)));
    }
    frame.clear_intensity();
    for (std::size_t i = 0; i < layout.size(); ++i) {
      // A spring along the texel's normal, and the plane across it.
      const double along = direction.dot(layout.normal(i));
      const double over = direction.dot(layout.position(i)) - (highest - 0.001);
      const double depth = along > 0.1 ? std::max(0.0, over / along) : 0.0;
      frame.add_intensity(static_cast<std::uint32_t>(
          std::round(layout.scale[i] * pad.model.law.stiffness * depth / 1e-6)));
    }
    const touch::FeltPad felt = felt_pad(frame, pad, false);
    const touch::PadTouch touch = touch::pad_touch(felt, counts_of(frame));
    ASSERT_TRUE(touch.center && touch.normal && touch.curvature) << direction.transpose();
    EXPECT_GT(touch.normal->direction.dot(direction), std::cos(0.05)) << direction.transpose();
    EXPECT_NEAR(touch.curvature->largest, 0, 5) << "1/m; the ball's is 50";
    EXPECT_NEAR(touch.curvature->smallest, 0, 5);
  }
}

TEST(PadTouch, ACurvedPadsFrameHasACountForEachCell) {
  const robot::HandModel hand = robot::read_hand_model("config/robots/ball_probe.yaml");
  msgs::TactileFrame frame;
  frame.set_rows(14);
  frame.set_columns(6);
  frame.set_newton_per_count(1e-3);
  frame.set_full_scale(4095);
  for (int i = 0; i < 84; ++i) frame.add_intensity(0);
  try {
    felt_pad(frame, hand.pads.at(0), false);
    FAIL() << "84 counts are not one for each cell";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("84 counts is none of pad 'tip'"), std::string::npos)
        << e.what();
  }
}

}  // namespace
}  // namespace prehend::convert
