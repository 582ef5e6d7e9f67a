#include "prehend/touch/hand_touch.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/robot/hand_model.h"
#include "tests/touch/pressed.h"

namespace prehend::touch {
namespace {

using testing::fine_pad;
using testing::pressed;

std::shared_ptr<const FeltPad> fine(int factor = 1) {
  return std::make_shared<const FeltPad>(fine_pad(factor));
}

/// A flat-ended cylinder of radius R, `deepest` deep.
auto disc(double radius, double deepest, double x0, double y0) {
  return [=](double x, double y) { return std::hypot(x - x0, y - y0) < radius ? deepest : 0.0; };
}

class HandTouchTest : public ::testing::Test {
 protected:
  const HandTouch touch_{robot::read_hand_model("config/robots/pg70.yaml")};
};

TEST_F(HandTouchTest, SaysWhereEachPadTouchesInTheHandsFrame) {
  const auto pad = fine();
  const std::vector<PadFrame> frames{
      {"left", pad, pressed(*pad, disc(0.008, 5e-4, 0.002, 0.01))},
      {"right", pad, pressed(*pad, disc(0.008, 5e-4, -0.002, 0.01))}};
  const auto contacts = touch_.contacts({"hand_opening"}, {0.02}, frames);
  ASSERT_EQ(contacts.size(), 2u);
  const PadContact &left = contacts[0], &right = contacts[1];
  EXPECT_EQ(left.pad, "left");
  EXPECT_NEAR(left.force, right.force, 0.1 * left.force);
  EXPECT_NEAR(left.place.x(), 0.002, 5e-4);
  EXPECT_NEAR(left.place.y(), 0.01, 5e-4);
  EXPECT_NEAR(left.margin, 6 * 0.0034 / 2 - 0.002, 5e-4) << "to the pad's side";
  EXPECT_NEAR(left.margin_to_tip, 14 * 0.0034 / 2 - 0.01, 5e-4);
  // They face one another, an opening of 40 mm apart.
  EXPECT_NEAR(left.n_H.dot(right.n_H), -1, 1e-9);
  EXPECT_NEAR((right.p_H - left.p_H).dot(left.n_H), 0.04, 1e-6);
  // The right pad's x runs against the left one's, so that they touch at the same place.
  EXPECT_NEAR((right.p_H - left.p_H).norm(), 0.04, 1e-6);
}

TEST_F(HandTouchTest, ForceAndArmOfADiscAreTheClosedForms) {
  const auto pad = fine(4);
  const double radius = 0.008, depth = 5e-4;
  const auto contacts = touch_.contacts({"opening"}, {0.02},
                                        {{"left", pad, pressed(*pad, disc(radius, depth, 0, 0))}});
  ASSERT_EQ(contacts.size(), 1u);
  const double area = M_PI * radius * radius;
  EXPECT_NEAR(contacts[0].area, area, 0.03 * area);
  EXPECT_NEAR(contacts[0].arm, 2.0 / 3 * radius, 0.02 * radius);
  EXPECT_NEAR(contacts[0].spread.x(), radius / 2, 0.02 * radius);
  const double stiffness = pad->law.stiffness / contact::kReferenceTexelArea;
  EXPECT_NEAR(contacts[0].force, stiffness * area * depth, 0.03 * stiffness * area * depth);
}

TEST_F(HandTouchTest, LeavesOutPadsThatFeelNothing) {
  const auto pad = fine();
  const std::vector<double> none(pad->layout.size(), 0.0);
  EXPECT_TRUE(touch_.contacts({"opening"}, {0.02}, {{"left", pad, none}}).empty());
}

TEST_F(HandTouchTest, RefusesWhatItCannotPlace) {
  const auto pad = fine();
  const std::vector<double> counts(pad->layout.size(), 0.0);
  EXPECT_THROW(touch_.contacts({"other"}, {0.02}, {}), std::invalid_argument);
  EXPECT_THROW(touch_.contacts({"opening"}, {0.02}, {{"thumb", pad, counts}}),
               std::invalid_argument);
  EXPECT_THROW(touch_.contacts({"opening"}, {0.02}, {{"left", pad, {1, 2, 3}}}),
               std::invalid_argument);
}

// Fingers bring their pads along: the same frames, elsewhere.
TEST(HandTouchOfFingers, FollowsTheJoints) {
  const robot::HandModel hand = robot::read_hand_model("config/robots/sdh2.yaml");
  const HandTouch touch(hand);
  const robot::HandPad& pad = hand.pads.back();
  const auto felt = felt_pad_of(pad);
  const std::vector<PadFrame> frames{
      {pad.name, felt, std::vector<double>(felt->layout.size(), 1000)}};
  const Eigen::VectorXd open = hand.preshapes.front().open;
  const std::vector<std::string> names = hand.actuated_names();
  const auto at = [&](const Eigen::VectorXd& q) {
    return touch.contacts(names, {q.begin(), q.end()}, frames).at(0);
  };
  for (const double bend : {0.0, 0.3}) {
    const Eigen::VectorXd q = (open.array() + bend).matrix();
    std::vector<geometry::RigidTransform> X_HL;
    hand.link_poses(hand.all_positions(q), X_HL);
    const geometry::RigidTransform X_HP = X_HL[static_cast<std::size_t>(pad.link)] * pad.X_LP;
    EXPECT_LT((at(q).p_H - X_HP.translation()).norm(), 1e-3) << bend;
    EXPECT_LT((at(q).n_H - X_HP.linear().col(2)).norm(), 1e-9) << bend;
  }
}

}  // namespace
}  // namespace prehend::touch
