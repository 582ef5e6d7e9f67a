#include "msgs/convert/touch.h"

#include <gtest/gtest.h>

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
  one.center_P = {0.002, -0.01};
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

}  // namespace
}  // namespace prehend::convert
