// A hand without an arm that executes a grasp: what it holds, and why it does not.

#include "prehend/simulation/hand_grasp.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/shapes.h"
#include "tests/grasp/hand_scene.h"
#include "tests/simulation/closed_hand.h"

namespace prehend::simulation {
namespace {

TEST(HandGrasp, HoldsABottleAndSaysWhereItTouched) {
  const robot::HandModel hand = robot::read_hand_model("config/robots/sdh2.yaml");
  HandGrasp grasp;
  grasp.preshape = "parallel";
  grasp.X_WG.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  grasp.X_WG.translation() = Eigen::Vector3d(0, 0, 0.07);
  grasp.closed = closed(hand, "parallel", 0.35);
  grasp.contacts = {{0, 0.03, 0.07}, {0, -0.03, 0.07}};
  HandGraspOptions options;
  options.mass = 0.4;
  const geometry::TriangleMesh bottle = make_bottle(0.03, 0.13);
  const HandGraspOutcome outcome = execute_hand_grasp(hand, grasp, bottle, options);
  EXPECT_TRUE(outcome.held) << outcome.reason;
  EXPECT_EQ(outcome.fingers, 3);
  EXPECT_FALSE(outcome.touched_early);
  EXPECT_LT(outcome.contact_error, 0.03);
  EXPECT_LT(outcome.slip, 0.01);
  const HandGraspOutcome again = execute_hand_grasp(hand, grasp, bottle, options);
  EXPECT_EQ(outcome.slip, again.slip) << "bitwise";
  EXPECT_EQ(outcome.contact_error, again.contact_error);
}

TEST(HandGrasp, GatheredFingersDoNotPushWhatIsBesideTheMiddle) {
  const grasp::TestHand hand("bh8");
  const robot::Preshape& shape = hand.model.preshape("spread_0");
  HandGrasp grasp;
  grasp.preshape = shape.name;
  grasp.X_WG.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  grasp.X_WG.translation() = Eigen::Vector3d(0, -0.02, 0.06);
  const geometry::TriangleMesh box = make_standing_box({0.06, 0.06, 0.1});
  const grasp::TouchedMesh touched(box);
  const auto closed =
      hand.close(shape.name, grasp.X_WG * (hand.model.X_HP * shape.X_PG).inverse(), touched.scene);
  grasp.closed.resize(hand.model.size());
  for (int i = 0; i < hand.model.size(); ++i) {
    grasp.closed[i] = closed.all[hand.model.actuated[static_cast<std::size_t>(i)]];
  }
  HandGraspOptions options;
  const HandGraspOutcome gathered = execute_hand_grasp(hand.model, grasp, box, options);
  options.gather = 0;
  const HandGraspOutcome at_once = execute_hand_grasp(hand.model, grasp, box, options);
  EXPECT_TRUE(gathered.held) << gathered.reason;
  EXPECT_LT(gathered.shift, 0.4 * at_once.shift);
  EXPECT_GT(at_once.shift, 0.01);
}

TEST(HandGrasp, SaysWhyNothingIsHeld) {
  const robot::HandModel hand = robot::read_hand_model("config/robots/bh8.yaml");
  HandGrasp grasp;
  grasp.X_WG.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  grasp.X_WG.translation() = Eigen::Vector3d(0.3, 0, 0.08);
  grasp.closed = closed(hand, "spread_0", 0.8);
  const geometry::TriangleMesh box = make_standing_box({0.05, 0.05, 0.1});
  const HandGraspOutcome beside = execute_hand_grasp(hand, grasp, box);
  EXPECT_FALSE(beside.held);
  EXPECT_EQ(beside.fingers, 0);
  EXPECT_EQ(beside.reason, "the fingers closed beside the object");
  grasp.X_WG.translation().x() = 0;
  HandGraspOptions slippery;
  slippery.friction = 0.02;
  slippery.mass = 2;
  const HandGraspOutcome slips = execute_hand_grasp(hand, grasp, box, slippery);
  EXPECT_FALSE(slips.held) << slips.reason;
  EXPECT_GT(slips.fingers, 1);
}

TEST(HandGrasp, RefusesWhatIsNoGrasp) {
  const robot::HandModel hand = robot::read_hand_model("config/robots/bh8.yaml");
  const geometry::TriangleMesh box = make_standing_box({0.05, 0.05, 0.1});
  HandGrasp grasp;
  EXPECT_THROW(execute_hand_grasp(hand, grasp, box), std::invalid_argument) << "no positions";
  grasp.closed = hand.preshapes.front().open;
  grasp.closed[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(execute_hand_grasp(hand, grasp, box), std::invalid_argument);
  grasp.closed = hand.preshapes.front().open;
  grasp.preshape = "spread_61";
  EXPECT_THROW(execute_hand_grasp(hand, grasp, box), geometry::InputError);
  grasp.preshape.clear();
  EXPECT_THROW(execute_hand_grasp(hand, grasp, {}), geometry::InputError);
}

}  // namespace
}  // namespace prehend::simulation
