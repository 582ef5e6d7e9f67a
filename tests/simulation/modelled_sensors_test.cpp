#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "prehend/simulation/tactile_sensor.h"

namespace prehend::simulation {
namespace {

TEST(TactileSensor, IdealPadRoundsCutsAndThresholds) {
  const TactileSensorOptions options;
  TactileSensor sensor(options);
  std::vector<double> forces(84, 0.0);
  forces[0] = 100 * options.newton_per_count;
  forces[1] = 9.6 * options.newton_per_count;
  forces[2] = 9 * options.newton_per_count;
  forces[3] = 100;
  const TactileFrameReading frame = sensor.sample(forces, 0.03);
  EXPECT_EQ(frame.counts[0], 100);
  EXPECT_EQ(frame.counts[1], 10) << "9.6 rounds to the threshold";
  EXPECT_EQ(frame.counts[2], 0) << "9 is below it";
  EXPECT_EQ(frame.counts[3], 4095);
  EXPECT_NEAR(frame.sum, options.newton_per_count * (100 + 10 + 4095), 1e-12);
}

TEST(TactileSensor, ImperfectionsAreOfTheirSize) {
  TactileSensorOptions options;
  options.gain_spread = 0.1;
  TactileSensor spread(options);
  const std::vector<double> one(84, 1000 * options.newton_per_count);
  const auto counts = spread.sample(one, 1).counts;
  const double mean = std::accumulate(counts.begin(), counts.end(), 0.0) / 84;
  double variance = 0;
  for (const auto c : counts) variance += (c - mean) * (c - mean) / 84;
  EXPECT_NEAR(mean, 1000, 40);
  EXPECT_NEAR(std::sqrt(variance), 100, 30);

  options = {};
  options.low_pass_time = 0.05;
  TactileSensor slow(options);
  EXPECT_NEAR(slow.sample(one, 0.05).counts[0], 1000 * (1 - std::exp(-1.0)), 1);

  options = {};
  options.noise = 5;
  options.dead = {7};
  TactileSensor noisy(options), same(options);
  double squares = 0;
  for (int i = 0; i < 200; ++i) {
    const auto frame = noisy.sample(one, 0.03);
    EXPECT_EQ(frame.counts, same.sample(one, 0.03).counts) << "same seed";
    EXPECT_EQ(frame.counts[7], 0);
    squares += std::pow(frame.counts[0] - 1000.0, 2) / 200;
  }
  EXPECT_NEAR(std::sqrt(squares), 5, 1);
}

// A load on one texel, shown by all: the impulse response has its width, and nothing is lost, at
// the pad's middle as at its edge.
TEST(TactileSensor, SpreadsLoadsToNeighboursWithoutLoss) {
  TactileSensorOptions options;
  options.spread = 0.004;
  options.threshold = 0;
  TactileSensor sensor(options);
  for (const int texel : {7 * 6 + 3, 0, 5}) {
    std::vector<double> forces(84, 0.0);
    forces[texel] = 2;
    const TactileFrameReading frame = sensor.sample(forces, 0.01);
    EXPECT_NEAR(frame.felt, 2, 1e-12);
    EXPECT_NEAR(frame.sum, 2, 84 * 0.5 * options.newton_per_count);
    const double ratio =
        static_cast<double>(frame.counts[texel + (texel == 5 ? -1 : 1)]) / frame.counts[texel];
    EXPECT_NEAR(ratio, std::exp(-0.5 * std::pow(0.0034 / 0.004, 2)), 2e-3);
  }
  // The variance along the rows, as far as they go.
  std::vector<double> forces(84, 0.0);
  forces[7 * 6 + 3] = 2.5;
  options.spread = 0.003;
  const auto counts = TactileSensor(options).sample(forces, 0.01).counts;
  double sum = 0, square = 0;
  for (int i = 0; i < 84; ++i) {
    sum += counts[i];
    square += counts[i] * std::pow((i / 6 - 7) * 0.0034, 2);
  }
  EXPECT_NEAR(std::sqrt(square / sum), 0.003, 5e-5);
}

TEST(TactileSensor, ShowsWhatWasALatencyAgo) {
  TactileSensorOptions options;
  options.latency = 0.025;
  options.threshold = 0;
  TactileSensor sensor(options);
  const auto ramp = [&](double t) {
    return std::vector<double>(84, 1000 * options.newton_per_count * t);
  };
  for (int i = 0; i <= 100; ++i) {
    const double t = 0.01 * i, shown = sensor.sample(ramp(t), i == 0 ? 0 : 0.01).counts[4];
    if (t > options.latency) {
      EXPECT_NEAR(shown, 1000 * (t - options.latency), 0.51) << t;
    } else if (t < options.latency) {
      EXPECT_EQ(shown, 0);
    }
  }
}

TEST(TactileSensor, ZerosAreOffAndWander) {
  TactileSensorOptions options;
  options.offset = 20;
  options.threshold = 0;
  const std::vector<double> load(84, 1000 * options.newton_per_count);
  TactileSensor off(options);
  const auto counts = off.sample(load, 0).counts;
  EXPECT_EQ(counts, off.sample(load, 3600).counts) << "an offset stays";
  const auto deviation = [](const std::vector<std::uint16_t>& values, double mean) {
    double squares = 0;
    for (const auto c : values) squares += (c - mean) * (c - mean) / 84;
    return std::sqrt(squares);
  };
  EXPECT_NEAR(deviation(counts, 1000), 20, 6);
  options.offset = 0;
  options.drift = 20;
  TactileSensor wanders(options);
  EXPECT_EQ(wanders.sample(load, 0).counts[3], 1000);
  for (int i = 0; i < 100; ++i) wanders.sample(load, 4 * 36);
  EXPECT_NEAR(deviation(wanders.sample(load, 0).counts, 1000), 40, 12) << "4 h";
}

TEST(TactileSensor, AgesWithLoadCyclesAlone) {
  TactileSensorOptions options;
  options.ageing = 0.01;
  const std::vector<double> load(84, 1000 * options.newton_per_count), none(84, 0.0);
  TactileSensor sensor(options);
  for (int i = 0; i < 10; ++i) {
    for (int k = 0; k < 3; ++k) sensor.sample(load, 1);  // held, not pressed again
    sensor.sample(none, 1);
  }
  EXPECT_NEAR(sensor.sample(load, 1).counts[0], 1000 * std::pow(0.99, 10), 0.51);
  options.load_cycles = 50;
  EXPECT_NEAR(TactileSensor(options).sample(load, 1).counts[0], 1000 * std::pow(0.99, 50), 0.51);
}

TEST(TactileSensor, DeadRowsAndColumnsSayNothing) {
  TactileSensorOptions options;
  options.dead_rows = {2, 13};
  options.dead_columns = {5};
  options.offset = options.noise = 5;
  const auto counts = TactileSensor(options).sample(std::vector<double>(84, 0.5), 1).counts;
  for (int i = 0; i < 84; ++i) {
    const bool dead = i / 6 == 2 || i / 6 == 13 || i % 6 == 5;
    EXPECT_EQ(counts[i] == 0, dead) << i;
  }
}

TEST(TactileSensor, KeepsWhatItHasToShowStill) {
  TactileSensorOptions options = TactileSensorOptions::realistic();
  options.latency = 0.03;
  TactileSensor sensor(options), other(options);
  for (int i = 0; i < 9; ++i) sensor.sample(std::vector<double>(84, 0.1 * i), 0.01);
  StateWriter writer;
  writer(sensor);
  StateReader reader(writer.bytes(), "the sensor");
  reader(other);
  for (int i = 0; i < 9; ++i) {
    const std::vector<double> load(84, 1 - 0.1 * i);
    EXPECT_EQ(sensor.sample(load, 0.01).counts, other.sample(load, 0.01).counts);
  }
}

TEST(TactileSensor, RefusesBadInput) {
  TactileSensorOptions options;
  options.dead_rows = {14};
  EXPECT_THROW(TactileSensor{options}, std::invalid_argument);
  options = {};
  options.gains = {1, 1};
  EXPECT_THROW(TactileSensor{options}, std::invalid_argument);
  options = {};
  options.spread = -1;
  EXPECT_THROW(TactileSensor{options}, std::invalid_argument);
  options = {};
  options.load_cycles = 5;
  EXPECT_THROW(TactileSensor{options}, std::invalid_argument) << "without ageing";
  options = {};
  options.dead = {84};
  EXPECT_THROW(TactileSensor{options}, std::invalid_argument);
  options = {};
  options.newton_per_count = 0;
  EXPECT_THROW(TactileSensor{options}, std::invalid_argument);
  TactileSensor sensor({});
  EXPECT_THROW(sensor.sample({1, 2}, 0.1), std::invalid_argument);
  EXPECT_THROW(sensor.sample(std::vector<double>(84, 1.0), -1), std::invalid_argument);
}

TEST(WrenchSensor, RoundsCutsAndIsBiased) {
  WrenchSensorOptions options;
  options.bias[2] = 0.5;
  WrenchSensor sensor(options);
  Eigen::Matrix<double, 6, 1> wrench;
  wrench << 1.234, -1000, 2, 0.12345, 0, 99;
  const auto shown = sensor.sample(wrench);
  EXPECT_NEAR(shown[0], 1.23, 1e-12);
  EXPECT_EQ(shown[1], -300);
  EXPECT_NEAR(shown[2], 2.5, 1e-12);
  EXPECT_NEAR(shown[3], 0.123, 1e-12);
  EXPECT_EQ(shown[5], 30);
  options.force_noise = 0.1;
  WrenchSensor noisy(options);
  double squares = 0;
  for (int i = 0; i < 2000; ++i) squares += std::pow(noisy.sample(wrench)[0] - 1.234, 2) / 2000;
  EXPECT_NEAR(std::sqrt(squares), 0.1, 0.01);
  options.force_range = -1;
  EXPECT_THROW(WrenchSensor{options}, std::invalid_argument);
}

}  // namespace
}  // namespace prehend::simulation
