#include "prehend/touch/slip_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/touch/pressed.h"

namespace prehend::touch {
namespace {

using testing::fine_pad;
using ::testing::HasSubstr;
using testing::pressed;

// Two rounded feet, as foam shows them; moved by (x, y) and turned about the middle.
std::vector<double> feet(const FeltPad& pad, double x, double y, double turn = 0) {
  return pressed(pad, [=](double px, double py) {
    const double c = std::cos(turn), s = std::sin(turn);
    const double u = c * (px - x) + s * (py - y), v = -s * (px - x) + c * (py - y);
    const auto foot = [&](double at) {
      return 1.5e-3 * std::exp(-(u * u + (v - at) * (v - at)) / (2 * 0.0045 * 0.0045));
    };
    return foot(0.009) + foot(-0.009);
  });
}

SlipReading moved(const FeltPad& pad, double x, double y, double turn = 0) {
  SlipWatch watch(pad);
  watch.update(0, feet(pad, 0, 0));
  return watch.update(0.1, feet(pad, x, y, turn));
}

TEST(SlipWatch, FollowsAShiftOfThePattern) {
  const FeltPad pad = fine_pad();
  for (const auto& [x, y] : {std::pair{0.0005, 0.0}, {0.0, -0.001}, {0.001, 0.0015}}) {
    const SlipReading reading = moved(pad, x, y);
    ASSERT_TRUE(reading.determined) << reading.reason;
    EXPECT_NEAR(reading.shift.x(), x, 0.0001);
    EXPECT_NEAR(reading.shift.y(), y, 0.00015);
    EXPECT_NEAR(reading.turn, 0, 0.01);
    EXPECT_NEAR(reading.duration, 0.1, 1e-12);
    EXPECT_GT(reading.slipping, 20);
  }
}

TEST(SlipWatch, FollowsATurnWhereTheMiddleSticks) {
  const FeltPad pad = fine_pad();
  const SlipReading reading = moved(pad, 0, 0, 0.1);
  ASSERT_TRUE(reading.determined) << reading.reason;
  EXPECT_NEAR(reading.turn, 0.1, 0.01);
  EXPECT_NEAR(reading.shift.norm(), 0, 1e-4);
  EXPECT_EQ(reading.texels[2 * 6 + 2], TexelSlip::kSlips);
  EXPECT_EQ(reading.texels[6 * 6 + 2], TexelSlip::kSticks);
}

TEST(SlipWatch, WhatIsPressedHarderSticks) {
  const FeltPad pad = fine_pad();
  SlipWatch watch(pad);
  std::vector<double> counts = feet(pad, 0, 0);
  watch.update(0, counts);
  for (double& count : counts) count *= 1.3;
  const SlipReading reading = watch.update(0.1, counts);
  ASSERT_TRUE(reading.determined) << reading.reason;
  EXPECT_LT(reading.shift.norm(), 1e-5);
  EXPECT_EQ(reading.slipping, 0);
}

TEST(SlipWatch, ABallDoesNotShowItsTurnButItsShift) {
  const FeltPad pad = fine_pad();
  SlipWatch watch(pad);
  const auto round = [&](double x) {
    return pressed(pad, [=](double px, double py) {
      return 2e-3 * std::exp(-((px - x) * (px - x) + py * py) / (2 * 0.004 * 0.004));
    });
  };
  watch.update(0, round(0));
  const SlipReading reading = watch.update(0.1, round(0.0008));
  ASSERT_TRUE(reading.determined) << reading.reason;
  EXPECT_NEAR(reading.shift.x(), 0.0008, 1e-4);
  EXPECT_NEAR(reading.turn, 0, 0.02);
}

TEST(SlipWatch, SaysWhenItCannotTell) {
  const FeltPad pad = fine_pad();
  SlipWatch watch(pad);
  EXPECT_THAT(watch.update(0, std::vector<double>(84, 0.0)).reason, HasSubstr("nothing touches"));
  const SlipReading early = watch.update(0.02, feet(pad, 0, 0));
  EXPECT_FALSE(early.determined);
  EXPECT_THAT(early.reason, HasSubstr("no frame of 0.1 s ago"));
  EXPECT_EQ(early.texels[2 * 6 + 2], TexelSlip::kUnknown);

  SlipWatch even(pad);
  even.update(0, std::vector<double>(84, 1e6));
  const SlipReading flat = even.update(0.1, std::vector<double>(84, 1.01e6));
  EXPECT_FALSE(flat.determined);
  EXPECT_THAT(flat.reason, HasSubstr("too even"));

  // An edge across the pad shows motion across it alone.
  SlipWatch edge(pad);
  const auto half = [&](double at) {
    return pressed(pad, [=](double, double y) { return 1e-3 / (1 + std::exp((y - at) / 0.002)); });
  };
  edge.update(0, half(0));
  const SlipReading along = edge.update(0.1, half(0.001));
  EXPECT_FALSE(along.determined) << along.deviation << ", " << along.shift.transpose();

  std::vector<double> blind(84, std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(edge.update(0.2, blind).reason, HasSubstr("nothing touches"));
  EXPECT_THROW(edge.update(0.3, std::vector<double>(3, 0.0)), std::invalid_argument);
  EXPECT_THROW(SlipWatch(pad, {.window = -1}), std::invalid_argument);
}

TEST(SlipWatch, BeginsAnewWhenTimeJumpsBack) {
  const FeltPad pad = fine_pad();
  SlipWatch watch(pad);
  watch.update(5, feet(pad, 0, 0));
  EXPECT_FALSE(watch.update(1, feet(pad, 0.001, 0)).determined);
  EXPECT_TRUE(watch.update(1.1, feet(pad, 0.001, 0)).determined);
}

}  // namespace
}  // namespace prehend::touch
