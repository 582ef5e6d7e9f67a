// What is perceived of an act, from what sensors say while it is done.

#include "prehend/belief/act_perceiver.h"

#include <gtest/gtest.h>

#include "prehend/robot/platform.h"

namespace prehend::belief {
namespace {

/// When the jaws of a PG70 stopped that come with `speed` [m/s] of each to 3 mm before 30 mm,
/// slowly from there on, touch there, and go on by 1.5 mm in half a second.
std::optional<double> stopped(double speed, bool touches = true) {
  const robot::HandModel hand = robot::read_platform("config/robots/stage_pg70.yaml").hand;
  const robot::Preshape& preshape = hand.preshapes.front();
  Eigen::VectorXd closed = preshape.open;
  closed.setConstant(0.015);
  ActPerceiver perceiver(hand, robot::closing_way(hand, preshape, preshape.open, closed), 0.3);
  constexpr double kTouch = 0.03, kNear = 0.003, kSlow = 0.01, kGoesOn = 0.0015, kPress = 0.5;
  ActMoment moment;
  moment.pads.resize(hand.pads.size());
  double jaw = preshape.open[0], touched_at = 0;
  for (double time = 0; time < 5; time += 0.01) {
    moment.time = time;
    if (jaw > kTouch) {
      jaw = std::max(kTouch, jaw - 0.01 * (jaw > kTouch + kNear ? speed : kSlow));
      if (jaw == kTouch) touched_at = time;
    } else {
      jaw = kTouch - kGoesOn * std::min(1.0, (time - touched_at) / kPress);
      if (touches) moment.pads[0].force = moment.pads[1].force = 5;
    }
    moment.motors = Eigen::VectorXd::Constant(preshape.open.size(), jaw);
    perceiver.closing(moment);
  }
  perceiver.closed(moment);
  return perceiver.percepts().motors[0].stopped_after;
}

// The cycle comes fast to where it is predicted to touch, what is foretold does not: neither is a
// surprise.
TEST(ActPerceiver, AJawStopsAsLongAfterItsTouchHoweverFastItCame) {
  const auto slow = stopped(0.002), fast = stopped(0.05);
  ASSERT_TRUE(slow && fast);
  EXPECT_NEAR(*slow, *fast, 0.021);
  EXPECT_LT(*fast, 0.1) << "2 mm before its end it stands";
}

TEST(ActPerceiver, AJawThatTouchesNothingStopsAtNoTime) { EXPECT_FALSE(stopped(0.02, false)); }

}  // namespace
}  // namespace prehend::belief
