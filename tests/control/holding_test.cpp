// Whether something is held, from the wrist's force and the fingers alone.

#include "prehend/control/holding.h"

#include <random>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prehend::control {
namespace {

using ::testing::HasSubstr;
using Force = std::optional<Eigen::Vector3d>;

/// A sensor with an offset and noise [N].
struct Wrist {
  double noise = 0;
  Eigen::Vector3d offset{0.4, -0.3, 1};
  std::mt19937_64 random{7};
  Force operator()(double weight) {
    std::normal_distribution<double> normal(0, noise > 0 ? noise : 1);
    Eigen::Vector3d force = offset + Eigen::Vector3d(0, 0, weight);
    for (int k = 0; noise > 0 && k < 3; ++k) force[k] += normal(random);
    return force;
  }
};

Holding gripped(Wrist& wrist, std::optional<double> closure = 0.1, double way_left = 0.4) {
  Holding holding;
  for (int i = 0; i < 10; ++i) holding.feel_free(wrist(0));
  holding.grip(closure, way_left);
  return holding;
}

Holding::Verdict weighed(Holding& holding, Wrist& wrist, double weight,
                         std::optional<double> closure = 0.1) {
  holding.begin_weighing();
  for (int i = 0; i < 20; ++i) holding.weigh(wrist(weight));
  return holding.held(closure);
}

TEST(ForceAverage, HasMeanAndDeviation) {
  ForceAverage average;
  EXPECT_EQ(average.deviation(), 0);
  Wrist wrist{0.5};
  for (int i = 0; i < 20000; ++i) average.add(*wrist(2));
  average.add({std::nan(""), 0, 0});
  EXPECT_EQ(average.count(), 20000);
  EXPECT_NEAR((average.mean() - Eigen::Vector3d(0.4, -0.3, 3)).norm(), 0, 0.02);
  EXPECT_NEAR(average.deviation(), 0.5, 0.01);
}

// Regression: 30 % of a weight at a guessed density was asked for, and a box of 0.3 kg let go.
TEST(Holding, AnyWeightAboveTheNoiseIsHeldWhateverWasPredicted) {
  Wrist wrist{0.05};
  for (const double weight : {0.3, 1.0, 2.9, 30.0}) {
    Holding holding = gripped(wrist);
    const auto verdict = weighed(holding, wrist, weight);
    EXPECT_TRUE(verdict.yes) << weight << ": " << verdict.why;
    EXPECT_NEAR(*holding.weight(), weight, 0.05);
  }
  Holding holding = gripped(wrist);
  EXPECT_FALSE(weighed(holding, wrist, 0).yes) << "left on the table";
}

TEST(Holding, NoiseIsNoObject) {
  for (int seed = 1; seed <= 300; ++seed) {
    Wrist wrist{0.2};
    wrist.random.seed(static_cast<std::uint64_t>(seed));
    Holding holding = gripped(wrist, std::nullopt);
    EXPECT_FALSE(weighed(holding, wrist, 0, std::nullopt).yes) << seed;
  }
}

TEST(Holding, FingersThatWentOnClosingHoldNothing) {
  Wrist wrist;
  Holding holding = gripped(wrist);
  const auto verdict = weighed(holding, wrist, 3, 0.35);
  EXPECT_FALSE(verdict.yes);
  EXPECT_THAT(verdict.why, HasSubstr("0.25 rad"));
  // Near the end of their way less is enough.
  Holding near_end = gripped(wrist, 0.1, 0.1);
  EXPECT_FALSE(weighed(near_end, wrist, 3, 0.19).yes);
  EXPECT_TRUE(weighed(near_end, wrist, 3, 0.15).yes);
}

TEST(Holding, WithoutAForceTheFingersDecideAndWithoutBothNothingIsHeld) {
  Wrist wrist;
  Holding holding;
  holding.grip(0.1, 0.4);
  holding.begin_weighing();
  EXPECT_TRUE(holding.held(0.12).yes);
  EXPECT_FALSE(holding.weight());
  EXPECT_FALSE(holding.held(0.5).yes);
  EXPECT_THAT(holding.held(std::nullopt).why, HasSubstr("cannot be told"));
  EXPECT_FALSE(holding.held(std::nullopt).yes);
  // As good as none: the noise hides a kilogram.
  Wrist noisy{5};
  Holding deaf = gripped(noisy);
  EXPECT_TRUE(weighed(deaf, noisy, 2).yes);
  EXPECT_FALSE(deaf.weight());
}

TEST(Holding, AWeightThatGoesIsLostAfterAWhile) {
  Wrist wrist{0.05};
  Holding holding = gripped(wrist);
  ASSERT_TRUE(weighed(holding, wrist, 3).yes);
  double time = 10;
  const auto run = [&](double seconds, double weight) {
    for (const double end = time + seconds; time < end; time += 0.02) {
      if (const auto why = holding.lost(time, wrist(weight), 0.12, true); !why.empty()) return why;
    }
    return std::string();
  };
  EXPECT_EQ(run(2, 3), "");
  EXPECT_EQ(run(1, 1.5), "") << "braked downwards";
  EXPECT_EQ(run(0.1, 0), "") << "a shake";
  EXPECT_EQ(run(1, 3), "");
  const double before = time;
  EXPECT_THAT(run(2, 0), HasSubstr("N that were lifted"));
  EXPECT_LT(time - before, 0.6);
  // Where a table may bear it, the weight says nothing; the fingers do.
  EXPECT_EQ(holding.lost(time, wrist(0), 0.12, false), "");
  EXPECT_THAT(holding.lost(time, wrist(0), 0.4, false), HasSubstr("closed"));
}

TEST(Holding, AnOpenHandIsEmptyWhenItBearsNothing) {
  Wrist wrist{0.05};
  Holding holding = gripped(wrist);
  ASSERT_TRUE(weighed(holding, wrist, 3).yes);
  const auto after = [&](double weight) {
    holding.begin_weighing();
    for (int i = 0; i < 20; ++i) holding.weigh(wrist(weight));
    return holding.empty();
  };
  EXPECT_TRUE(after(0).yes);
  EXPECT_FALSE(after(3).yes) << "it sticks";
  holding.begin();
  EXPECT_FALSE(holding.weight());
}

TEST(Holding, RefusesOptionsOutOfRange) {
  const auto refused = [](auto change) {
    HoldingOptions options;
    change(options);
    EXPECT_THROW(Holding{options}, std::invalid_argument);
  };
  refused([](HoldingOptions& o) { o.resolution = 0; });
  refused([](HoldingOptions& o) { o.significance = 0; });
  refused([](HoldingOptions& o) { o.deciding_force = 0; });
  refused([](HoldingOptions& o) { o.lost_share = 1; });
  refused([](HoldingOptions& o) { o.lost_time = 0; });
  refused([](HoldingOptions& o) { o.advance = 0; });
}

}  // namespace
}  // namespace prehend::control
