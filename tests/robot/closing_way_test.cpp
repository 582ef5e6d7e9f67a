#include "prehend/robot/closing_way.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::robot {
namespace {

Eigen::VectorXd values(std::initializer_list<double> list) {
  return Eigen::Map<const Eigen::VectorXd>(list.begin(), static_cast<Eigen::Index>(list.size()));
}

// A joint that closes, one that does so backwards and half as fast, one that stays.
ClosingWay way() {
  return {values({0, 0, 0.3}), values({1, -0.5, 0.3}), values({1, -0.5, 0}),
          values({-0.1, -0.7, 0}), values({1.2, 0.1, 1})};
}

TEST(ClosingWay, GoesOnByRateAndNoFartherThanTheLimits) {
  EXPECT_TRUE(way().at(0).isApprox(values({1, -0.5, 0.3})));
  EXPECT_TRUE(way().at(0.1).isApprox(values({1.1, -0.55, 0.3})));
  EXPECT_TRUE(way().at(0.5).isApprox(values({1.2, -0.7, 0.3})));
  EXPECT_TRUE(way().at(-0.2).isApprox(values({0.8, -0.4, 0.3})));
  EXPECT_TRUE(way().at(-5).isApprox(values({0, 0, 0.3}))) << "back to where it is open";
}

TEST(ClosingWay, ClosureCountsTheJointsThatClose) {
  EXPECT_NEAR(way().closure(values({1.2, -0.6, 0.9})), 0.2, 1e-12);
  EXPECT_NEAR(way().closure(way().at(-0.2)), -0.2, 1e-12);
  ClosingWay still = way();
  still.rate.setZero();
  EXPECT_EQ(still.closure(values({2, 2, 2})), 0);
}

TEST(ClosingWay, EveryPreshapeStaysWithinTheLimitsOfItsHand) {
  for (const char* file : {"sdh2.yaml", "bh8.yaml", "sensorhand.yaml", "pg70.yaml"}) {
    const HandModel hand = read_hand_model(std::string("config/robots/") + file);
    for (const Preshape& preshape : hand.preshapes) {
      const ClosingWay of_hand = closing_way(hand, preshape, {}, preshape.open);
      EXPECT_EQ(of_hand.open, preshape.open);
      for (const double beyond : {-1.0, 0.0, 0.5, 3.0, 100.0}) {
        const Eigen::VectorXd at = of_hand.at(beyond);
        EXPECT_TRUE((at.array() >= of_hand.lower.array()).all()) << file << preshape.name;
        EXPECT_TRUE((at.array() <= of_hand.upper.array()).all()) << file << preshape.name;
      }
    }
  }
}

TEST(ClosingWay, RefusesWhatDoesNotBelongTogether) {
  ClosingWay other = way();
  other.open.resize(2);
  EXPECT_THROW(other.validate(), std::invalid_argument);
  other = way();
  other.closed[1] = std::nan("");
  EXPECT_THROW(other.validate(), std::invalid_argument);
  other = way();
  other.lower[0] = 3;
  EXPECT_THROW(other.validate(), std::invalid_argument);
}

// Jaws were sent 0.1 m back and 0.5 m on, as if these were radians.
TEST(ClosingWay, JawsThatSlideCloseLikeFingersOfTenCentimetres) {
  const HandModel hand = read_hand_model("config/robots/pg70.yaml");
  ASSERT_TRUE(hand.gripper);
  const ClosingWay jaws =
      closing_way(hand, hand.preshapes.front(), values({0.0345}), values({0.02}));
  EXPECT_NEAR(jaws.at(-0.1)[0], 0.03, 1e-12);
  EXPECT_NEAR(jaws.at(0.05)[0], 0.015, 1e-12);
  EXPECT_NEAR(jaws.at(0.5)[0], 0, 1e-12);
  EXPECT_NEAR(jaws.closure(values({0.01})), 0.1, 1e-12);
}

}  // namespace
}  // namespace prehend::robot
