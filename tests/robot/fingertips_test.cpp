#include "prehend/robot/fingertips.h"

#include <string>

#include <gtest/gtest.h>

namespace prehend::robot {
namespace {

// Fingers close towards one another: what the tips of opposite ones do cancels out.
TEST(FingertipWays, OfEachHandCloseIntoItsMiddle) {
  for (const char* file : {"sdh2.yaml", "bh8.yaml"}) {
    SCOPED_TRACE(file);
    const HandModel hand = read_hand_model(std::string("config/robots/") + file);
    const Preshape& preshape = hand.preshapes.front();
    const FingertipWays tips = fingertip_ways(hand, preshape.open);
    ASSERT_EQ(tips.ways.cols(), hand.size());
    ASSERT_EQ(tips.finger.size(), static_cast<std::size_t>(hand.size()));
    Eigen::Vector3d closing = Eigen::Vector3d::UnitY();
    closing = (hand.X_HP * preshape.X_PG).linear() * closing;
    double to_one_side = 0, to_the_other = 0;
    for (int i = 0; i < hand.size(); ++i) {
      const double rate = preshape.closing[static_cast<std::size_t>(i)].rate;
      if (rate == 0) continue;
      EXPECT_GE(tips.finger[static_cast<std::size_t>(i)], 0) << i;
      const double along = rate * closing.dot(tips.ways.col(i));
      (along > 0 ? to_one_side : to_the_other) += along;
    }
    EXPECT_GT(to_one_side, 0.02) << "m for each rad";
    EXPECT_LT(to_the_other, -0.02);
  }
}

TEST(FingertipWays, AreThoseOfAFinerStep) {
  const HandModel hand = read_hand_model("config/robots/sdh2.yaml");
  const Eigen::VectorXd at = hand.preshapes.front().open;
  const FingertipWays tips = fingertip_ways(hand, at);
  for (int i = 0; i < hand.size(); ++i) {
    Eigen::VectorXd further = at;
    further[i] += 1e-3;
    const Eigen::Vector3d there = fingertip_ways(hand, further).ways.col(i);
    EXPECT_LT((there - tips.ways.col(i)).norm(), 2e-3 * tips.ways.col(i).norm() + 1e-9)
        << "it turns by a thousandth of a rad";
  }
}

TEST(FingertipWays, OfJawsThatAreCoupledTellNothing) {
  const HandModel hand = read_hand_model("config/robots/pg70.yaml");
  const FingertipWays tips = fingertip_ways(hand, hand.preshapes.front().open);
  EXPECT_EQ(tips.ways.norm(), 0);
  for (const int finger : tips.finger) EXPECT_EQ(finger, -1);
}

}  // namespace
}  // namespace prehend::robot
