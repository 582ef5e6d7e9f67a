#include "msgs/convert/load.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "msgs/convert/load_bounds.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

using geometry::InputError;

TEST(LoadMessages, EvidenceComesAsItWasSent) {
  belief::LoadEvidence load;
  EXPECT_TRUE(from_message(to_message(load)).is_empty());
  load.weight = 2.9;
  load.weight_deviation = 0.04;
  load.held_share = 0.2;
  load.slipped_share = 0.31;
  load.borne = 2.5;
  msgs::LoadEvidence sent;
  ASSERT_TRUE(sent.ParseFromString(to_message(load).SerializeAsString()));
  const belief::LoadEvidence come = from_message(sent);
  EXPECT_EQ(come.weight, load.weight);
  EXPECT_EQ(come.weight_deviation, load.weight_deviation);
  EXPECT_EQ(come.held_share, load.held_share);
  EXPECT_EQ(come.slipped_share, load.slipped_share);
  EXPECT_EQ(come.borne, load.borne);
}

TEST(LoadMessages, HostileEvidenceIsRefused) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, -1.0}) {
    for (int field = 0; field < 5; ++field) {
      msgs::LoadEvidence message;
      if (field == 0) message.set_weight(bad);
      if (field == 1) message.set_weight_deviation(bad);
      if (field == 2) message.set_held_share(bad);
      if (field == 3) message.set_slipped_share(bad);
      if (field == 4) message.set_borne(bad);
      EXPECT_THROW(from_message(message), InputError) << field << " of " << bad;
    }
  }
}

TEST(LoadMessages, BoundsThatAreNotKnownAreAbsent) {
  msgs::ObjectModel model;
  set_load(grasp::LoadBounds{}, &model);
  EXPECT_FALSE(model.has_mass());
  EXPECT_FALSE(model.has_friction());
  EXPECT_FALSE(load_of(model).is_known());
  set_load({{0.28, 0.31}, {0, 0.4}}, &model);
  EXPECT_FALSE(model.friction().has_low());
  const grasp::LoadBounds load = load_of(model);
  EXPECT_EQ(load.mass.low, 0.28);
  EXPECT_EQ(load.mass.high, 0.31);
  EXPECT_EQ(load.friction.low, 0);
  EXPECT_EQ(load.friction.high, 0.4);
  msgs::Belief belief;
  set_load({{0.5}, {}}, &belief);
  EXPECT_TRUE(belief.has_mass());
  EXPECT_FALSE(belief.mass().has_high());
}

TEST(LoadMessages, BoundsThatMakeNoSenseAreRefused) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  const std::pair<double, double> bad[] = {{nan, 1}, {0, nan},  {-1, 1},       {2, 1},
                                           {0, 0},   {0, -0.1}, {infinity, 1}, {1, infinity}};
  for (const auto& [low, high] : bad) {
    msgs::ObjectModel model;
    model.mutable_friction()->set_low(low);
    model.mutable_friction()->set_high(high);
    try {
      load_of(model);
      ADD_FAILURE() << low << " to " << high;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("a friction of"));
    }
  }
}

}  // namespace
}  // namespace prehend::convert
