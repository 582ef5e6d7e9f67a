#include "prehend/touch/hold_slip.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/touch/pressed.h"

namespace prehend::touch {
namespace {

using testing::fine_pad;
using ::testing::HasSubstr;
using testing::pressed;

/// A hold of a rounded thing by two pads, frames every 20 ms; `change` may spoil the counts.
class HoldSlipTest : public ::testing::Test {
 protected:
  using Change = std::function<void(std::vector<double>*)>;

  std::vector<double> thing(double x, double y, double harder = 1) const {
    return pressed(*pad_, [=](double px, double py) {
      const double u = px - x, v = py - y;
      return harder * 1.5e-3 * std::exp(-(u * u + v * v) / (2 * 0.0065 * 0.0065));
    });
  }
  const HoldSlipReading& feel(double x, double y, double harder = 1, const Change& change = nullptr,
                              std::optional<Eigen::Vector3d> load = Eigen::Vector3d(0, 0, 1)) {
    std::vector<double> left = thing(x, y, harder), right = thing(-x, y, harder);
    if (change) {
      change(&left);
      change(&right);
    }
    time_ += 0.02;
    return slip_.update(time_, {{"left", pad_, left}, {"right", pad_, right}}, load);
  }
  void begin(const Change& change = nullptr) {
    slip_.begin(0);
    for (int i = 0; i < 4; ++i) feel(0, 0, 1, change);
  }

  std::shared_ptr<const FeltPad> pad_ = std::make_shared<FeltPad>(fine_pad());
  HoldSlip slip_;
  double time_ = 0;
};

// It slips in the first frame beyond 0.9 mm, or in the second where two are to say it.
TEST_F(HoldSlipTest, MeasuresAShiftThatGrows) {
  for (const auto& [frames, slips_at] : {std::pair{2, 1.5e-3}, std::pair{1, 1e-3}}) {
    HoldSlipOptions options;
    options.confirming_frames = frames;
    slip_ = HoldSlip(options);
    time_ = 0;
    begin();
    for (const double y : {2e-4, 5e-4, 1e-3, 1.5e-3}) {
      const HoldSlipReading& reading = feel(0, -y);
      ASSERT_TRUE(reading.determined) << reading.reason;
      EXPECT_NEAR(reading.slide, y, 0.1 * y + 2e-5);
      EXPECT_EQ(reading.pads, 2);
      EXPECT_EQ(reading.slips, y >= slips_at) << y << ", " << frames << " frames";
    }
  }
  EXPECT_NEAR(feel(1e-3, 1e-3).slide, std::sqrt(2) * 1e-3, 1.5e-4);
}

TEST_F(HoldSlipTest, WhatTheFoamGivesWayIsNoSlide) {
  begin();
  // As a spring of all touched texels: 3 N more.
  int touched = 0;
  for (const double count : thing(0, 0)) touched += count > pad_->threshold ? 1 : 0;
  const double stretch = 3 / (2 * touched * pad_->law.bristle_stiffness);
  for (int i = 0; i < 5; ++i) {
    const HoldSlipReading& reading = feel(0, -stretch, 1, nullptr, Eigen::Vector3d(0, 0, 4));
    EXPECT_NEAR(reading.stretch, stretch, 0.02 * stretch);
    EXPECT_NEAR(reading.slide, 0, 5e-5);
    EXPECT_FALSE(reading.slips);
  }
  // Without a load it may be as much as friction holds.
  double force = 0;
  for (const double count : thing(0, 0)) force += count * pad_->newton_per_count;
  const double holds = pad_->law.dynamic_friction * force / (touched * pad_->law.bristle_stiffness);
  EXPECT_NEAR(feel(0, 0, 1, nullptr, std::nullopt).stretch, holds, 0.02 * holds);
}

TEST_F(HoldSlipTest, NoiseAndPressingHarderDoNotSlip) {
  begin();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 2000; ++i) {
    const HoldSlipReading& reading = feel(
        0, 0, 1 + 0.2 * std::sin(0.1 * i),
        [&](auto* counts) {
          for (double& count : *counts) {
            count = std::max(0.0, count * (1 + 0.005 * normal(random)) + 2e3 * normal(random));
          }
        },
        Eigen::Vector3d(0, 0, 1 + 0.1 * normal(random)));
    ASSERT_FALSE(reading.slips) << i;
    ASSERT_LT(reading.slide, 3e-4);
  }
}

TEST_F(HoldSlipTest, SeesASlideInSpiteOfADeadRowAndABiasedPad) {
  const auto bad = [](std::vector<double>* counts) {
    for (std::size_t i = 0; i < counts->size(); ++i) (*counts)[i] *= i / 6 == 7 ? 0 : 1.2;
  };
  begin(bad);
  EXPECT_NEAR(feel(0, 0, 1, bad).slide, 0, 1e-5);
  feel(0, -0.8e-3, 1, bad);
  feel(0, -1.2e-3, 1, bad);
  const HoldSlipReading& reading = feel(0, -1.6e-3, 1, bad);
  EXPECT_TRUE(reading.slips) << reading.reason;
  EXPECT_NEAR(reading.slide, 1.6e-3, 4e-4);
}

TEST_F(HoldSlipTest, AFrameOfNaNTellsNothingAndTheNextDoes) {
  begin();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto none = [nan](auto* counts) { std::fill(counts->begin(), counts->end(), nan); };
  EXPECT_FALSE(feel(0, 0, 1, none).determined);
  const auto one = [nan](auto* counts) { (*counts)[20] = nan; };
  EXPECT_TRUE(feel(0, 0, 1, one).determined);
  const Eigen::Vector3d no_load(nan, 0, 0);
  EXPECT_TRUE(std::isfinite(feel(0, 0, 1, nullptr, no_load).slide));
  for (const double y : {0.8e-3, 1.2e-3, 1.6e-3}) feel(0, -y);
  EXPECT_TRUE(feel(0, -1.6e-3).slips);
}

TEST_F(HoldSlipTest, AnotherNumberOfTexelsTellsNothingUntilTheNextHold) {
  begin();
  const auto fewer = [](auto* counts) { counts->resize(10); };
  EXPECT_FALSE(feel(0, -1e-3, 1, fewer).determined);
  pad_ = std::make_shared<FeltPad>(fine_pad(2));
  EXPECT_FALSE(feel(0, 0).determined);
  slip_.begin(time_ + 0.01);
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(feel(0, 0).determined);
  EXPECT_TRUE(feel(0, -5e-4).determined);
}

TEST_F(HoldSlipTest, AFaceThatCoversThePadSaysThatItCannotTell) {
  slip_.begin(0);
  const std::vector<double> even(84, 1e6);
  for (int i = 0; i < 6; ++i) {
    time_ += 0.02;
    slip_.update(time_, {{"left", pad_, even}}, std::nullopt);
  }
  time_ += 0.02;
  const HoldSlipReading& reading = slip_.update(time_, {{"left", pad_, even}}, std::nullopt);
  EXPECT_FALSE(reading.determined);
  EXPECT_THAT(reading.reason, HasSubstr("too even"));
}

// An edge across the pad shows motion across it, though none along it.
TEST_F(HoldSlipTest, AnEdgeShowsMotionAcrossIt) {
  const auto edge = [&](double at) {
    const std::vector<double> counts =
        pressed(*pad_, [=](double, double y) { return 1e-3 / (1 + std::exp((y - at) / 0.002)); });
    time_ += 0.02;
    return slip_.update(time_, {{"left", pad_, counts}}, Eigen::Vector3d(0, 0, 1));
  };
  slip_.begin(0);
  for (int i = 0; i < 4; ++i) edge(0);
  EXPECT_NEAR(edge(-1e-3).slide, 1e-3, 1.5e-4);
}

// An edge that jumps to the next row has perhaps moved by a hair's breadth.
TEST_F(HoldSlipTest, OneJumpOfAnEdgeIsNoSlideAndWhatGoesOnIs) {
  begin();
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(feel(0, -1.2e-3).slips) << i;
  feel(0, -1.7e-3);
  EXPECT_TRUE(feel(0, -1.8e-3).slips);
}

// What tilts between the pads moves their patterns apart.
TEST_F(HoldSlipTest, PatternsThatMoveApartAreNoSlide) {
  begin();
  for (int i = 1; i < 20; ++i) {
    time_ += 0.02;
    const double y = 1e-4 * i;
    const HoldSlipReading& reading =
        slip_.update(time_, {{"left", pad_, thing(0, y)}, {"right", pad_, thing(0, -y)}},
                     Eigen::Vector3d(0, 0, 1));
    EXPECT_FALSE(reading.slips) << y;
  }
}

TEST(HoldSlipOptions, AreChecked) {
  HoldSlipOptions options;
  options.reference_frames = 0;
  EXPECT_THROW(HoldSlip{options}, std::invalid_argument);
  options = {};
  options.least_slide = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(HoldSlip{options}, std::invalid_argument);
}

}  // namespace
}  // namespace prehend::touch
