#include "prehend/belief/load_belief.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>

#include "prehend/belief/attempt_memory.h"
#include "prehend/geometry/gravity.h"
#include "prehend/robot/robot_files.h"
#include "tests/belief/predicted.h"

namespace prehend::belief {
namespace {

using geometry::kGravity;
using testing::HasSubstr;

LoadEvidence weighed(double mass, double deviation) {
  LoadEvidence one;
  one.weight = mass * kGravity;
  one.weight_deviation = deviation;
  return one;
}

TEST(LoadBelief, WithoutEvidenceNothingIsKnown) {
  EXPECT_FALSE(load_belief({}).bounds.is_known());
  EXPECT_FALSE(load_belief({LoadEvidence{}}).bounds.is_known());
  EXPECT_EQ(in_words(load_belief({}).bounds), "");
}

TEST(LoadBelief, AWeightBoundsTheMassByItsNoise) {
  LoadBeliefOptions options;
  options.weight_resolution = 0.1;
  options.significance = 3;
  const grasp::Interval mass = load_belief({weighed(0.3, 0.05)}, options).bounds.mass;
  EXPECT_NEAR(mass.low, 0.3 - (3 * 0.05 + 0.1) / kGravity, 1e-12);
  EXPECT_NEAR(mass.high, 0.3 + (3 * 0.05 + 0.1) / kGravity, 1e-12);
  // What is nothing beside the noise may be nothing.
  EXPECT_EQ(load_belief({weighed(0.001, 0.1)}).bounds.mass.low, 0);
}

// Coulomb: what holds has at least the share, what slips at most.
TEST(LoadBelief, HoldsAndSlipsBoundTheFriction) {
  LoadEvidence held, slipped;
  held.held_share = 0.25;
  slipped.slipped_share = 0.4;
  LoadBeliefOptions exact;
  exact.pad_gain = 0;
  const grasp::Interval friction = load_belief({held, slipped}, exact).bounds.friction;
  EXPECT_DOUBLE_EQ(friction.low, 0.25);
  EXPECT_DOUBLE_EQ(friction.high, 0.4);
  const grasp::Interval wider = load_belief({held, slipped}).bounds.friction;
  EXPECT_LT(wider.low, friction.low);
  EXPECT_GT(wider.high, friction.high);
}

// It slipped before it could be weighed: it weighs what the hand bore at least.
TEST(LoadBelief, WhatWasBorneWhenItSlippedIsTheLeastThatItWeighs) {
  LoadEvidence slipped;
  slipped.borne = 8;
  const grasp::Interval mass = load_belief({slipped}).bounds.mass;
  EXPECT_GT(mass.low, 0.3);
  EXPECT_LT(mass.low, 8 / kGravity);
  EXPECT_TRUE(std::isinf(mass.high));
}

TEST(LoadBelief, TheOrderOfEvidenceDoesNotMatter) {
  std::vector<LoadEvidence> all{weighed(0.3, 0.05), weighed(0.31, 0.02), weighed(0.29, 0.04)};
  all[1].held_share = 0.2;
  all[2].slipped_share = 0.5;
  all[0].slipped_share = 0.45;
  const grasp::LoadBounds first = load_belief(all).bounds;
  std::sort(all.begin(), all.end(),
            [](const auto& a, const auto& b) { return *a.weight < *b.weight; });
  do {
    const grasp::LoadBounds other = load_belief(all).bounds;
    EXPECT_EQ(other.mass.low, first.mass.low);
    EXPECT_EQ(other.mass.high, first.mass.high);
    EXPECT_EQ(other.friction.low, first.friction.low);
    EXPECT_EQ(other.friction.high, first.friction.high);
  } while (std::next_permutation(
      all.begin(), all.end(), [](const auto& a, const auto& b) { return *a.weight < *b.weight; }));
}

TEST(LoadBelief, SaysWhenItContradictsItself) {
  // Somebody has emptied the bottle.
  LoadBelief belief = load_belief({weighed(0.8, 0.02), weighed(0.1, 0.02)});
  EXPECT_THAT(belief.contradiction, HasSubstr("what it weighed contradicts itself"));
  EXPECT_FALSE(belief.bounds.is_known());
  LoadEvidence held, slipped;
  held.held_share = 0.9;
  slipped.slipped_share = 0.3;
  belief = load_belief({held, slipped});
  EXPECT_THAT(belief.contradiction, HasSubstr("how it held and slipped contradicts itself"));
  EXPECT_FALSE(belief.bounds.is_known());
}

TEST(LoadBelief, RefusesWhatIsNoEvidence) {
  const double nan = std::nan("");
  EXPECT_THROW(load_belief({weighed(nan, 0.1)}), std::invalid_argument);
  EXPECT_THROW(load_belief({weighed(-1, 0.1)}), std::invalid_argument);
  EXPECT_THROW(load_belief({weighed(1, std::numeric_limits<double>::infinity())}),
               std::invalid_argument);
  LoadEvidence slipped;
  slipped.slipped_share = nan;
  EXPECT_THROW(load_belief({slipped}), std::invalid_argument);
  LoadBeliefOptions options;
  options.pad_gain = 1;
  EXPECT_THROW(load_belief({}, options), std::invalid_argument);
}

TEST(LoadBelief, IsSaidInWords) {
  EXPECT_EQ(in_words({{0.281, 0.312}, {}}), "0.28 to 0.31 kg");
  EXPECT_EQ(in_words({{}, {0, 0.42}}), "friction at most 0.42");
  EXPECT_EQ(in_words({{0.5}, {0.2}}), "at least 0.5 kg, friction at least 0.2");
}

TEST(LoadBounds, WhatWasFoundOutGoesBeforeWhatWasAssumed) {
  using grasp::within;
  const grasp::Interval assumed{0.5, 0.8};
  EXPECT_EQ(within(assumed, {}).low, 0.5);
  EXPECT_EQ(within(assumed, {}).high, 0.8);
  EXPECT_EQ(within(assumed, {0.6, 0.7}).low, 0.6);
  EXPECT_EQ(within(assumed, {0, 0.7}).high, 0.7);
  const grasp::Interval slippery = within(assumed, {0, 0.4});
  EXPECT_DOUBLE_EQ(slippery.low, 0.25);
  EXPECT_DOUBLE_EQ(slippery.high, 0.4);
  const grasp::Interval sticky = within(assumed, {1.6});
  EXPECT_DOUBLE_EQ(sticky.low, 1.6);
  EXPECT_DOUBLE_EQ(sticky.high, 2.56);
  const grasp::Interval both = within(assumed, {0.1, 0.3});
  EXPECT_DOUBLE_EQ(both.low, 0.1875);
  EXPECT_DOUBLE_EQ(both.high, 0.3);
}

// It goes along with the object, and is forgotten where it contradicts itself.
TEST(AttemptMemoryLoad, IsKnownWhenItIsSeenAgainUntilItContradictsItself) {
  const Predicted predicted(shape::standing(geometry::make_box({0.08, 0.06, 0.1}), 0));
  const geometry::TriangleMesh surface_W =
      surface::mesh_of(predicted.shape, predicted.view.table_W);
  AttemptMemory memory(robot::read_hand_model("config/robots/pg70.yaml"));
  const auto tell = [&](const LoadEvidence& load) {
    memory.add_load(load, predicted.shape, predicted.view.table_W, surface_W);
    return memory.recall(predicted.shape, predicted.view.table_W);
  };
  EXPECT_FALSE(tell({})) << "a hold that told nothing";
  auto known = tell(weighed(0.3, 0.02));
  ASSERT_TRUE(known) << memory.problem();
  EXPECT_NEAR(known->load.mass.low, 0.28, 0.02);
  EXPECT_NEAR(known->load.mass.high, 0.32, 0.02);
  EXPECT_EQ(known->looks, 1);
  EXPECT_EQ(known->load_problem, "");
  LoadEvidence slipped;
  slipped.slipped_share = 0.3;
  known = tell(slipped);
  ASSERT_TRUE(known) << memory.problem();
  EXPECT_LT(known->load.friction.high, 0.4);
  EXPECT_NEAR(known->load.mass.high, 0.32, 0.02);
  known = tell(weighed(2, 0.02));
  ASSERT_TRUE(known) << "its surface is no other";
  EXPECT_FALSE(known->load.is_known());
  EXPECT_THAT(known->load_problem, HasSubstr("contradicts itself"));
  known = tell(weighed(2, 0.02));
  ASSERT_TRUE(known) << memory.problem();
  EXPECT_EQ(known->load_problem, "");
  EXPECT_NEAR(known->load.mass.low, 2, 0.03) << "it starts again";
}

}  // namespace
}  // namespace prehend::belief
