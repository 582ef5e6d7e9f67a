#include "prehend/touch/imprint_memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "tests/touch/pressed.h"

namespace prehend::touch {
namespace {

using ::testing::HasSubstr;
using Hole = std::function<bool(double, double)>;

bool bars(double x, double y) {
  return (std::abs(x) < 0.0042 && std::abs(y) < 0.0126) ||
         (std::abs(y) < 0.0042 && std::abs(x) < 0.0126);
}
bool square(double x, double y) { return std::abs(x) < 0.0084 && std::abs(y) < 0.0084; }
bool bar(double x, double y) { return std::abs(x) < 0.0042 && std::abs(y) < 0.014; }
bool ring(double x, double y) {
  const double r = std::hypot(x, y);
  return r < 0.0133 && r > 0.0056;
}

// A face with a hole, at any turn and place.
std::vector<Imprint> presses(const Hole& hole, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const FeltPad pad = testing::fine_pad();
  std::vector<Imprint> all;
  for (int k = 0; k < count; ++k) {
    const double turn = std::numbers::pi * unit(random), x0 = 0.003 * unit(random),
                 y0 = 0.012 * unit(random), force = 0.4 + 0.2 * unit(random);
    const double c = std::cos(turn), s = std::sin(turn);
    const auto counts = testing::pressed(pad, [&](double x, double y) {
      const double u = x - x0, v = y - y0;
      return hole(c * u - s * v, s * u + c * v) ? 0.0 : 1e-3 * force;
    });
    all.push_back(*imprint_of(pad, felt_texels(pad, counts)));
  }
  return all;
}

TEST(Imprint, SaysWhichTexelsArePressedWhateverTheForce) {
  const FeltPad pad = testing::fine_pad();
  std::vector<double> counts(84, 2e5);
  counts[0] = 0;
  counts[1] = 9e4;  // 0.45 of what the others feel
  counts[2] = std::numeric_limits<double>::quiet_NaN();
  const auto imprint = imprint_of(pad, felt_texels(pad, counts));
  ASSERT_TRUE(imprint);
  ASSERT_EQ(imprint->pressed.size(), 83u);
  EXPECT_EQ(imprint->pressed[0], 0);
  EXPECT_NEAR(imprint->pressed[1], 0.5, 1e-12);
  EXPECT_EQ(imprint->pressed[2], 1);
  counts[3] = 3e4;  // what foam spreads: less than a fifth
  EXPECT_EQ(imprint_of(pad, felt_texels(pad, counts))->pressed[2], 0);
  for (double& count : counts) count *= 3;
  EXPECT_EQ(imprint_of(pad, felt_texels(pad, counts))->pressed[0], 0);
  EXPECT_NEAR(imprint_of(pad, felt_texels(pad, counts))->pressed[1], 0.5, 1e-12);
  EXPECT_FALSE(imprint_of(pad, felt_texels(pad, std::vector<double>(84, 0.0))));
  std::vector<double> three(84, 0.0);
  three[4] = three[5] = three[6] = 1e5;
  EXPECT_FALSE(imprint_of(pad, felt_texels(pad, three)));
}

TEST(Imprint, IsTheSameWhereFoamSpreadsLoads) {
  // A Gaussian of 1.5 mm on texels of 3.4 mm, as realistic pads have: 7.6 % to the next one, along
  // rows and columns. With the soft edge that it leaves, realistic pads were recognised less often.
  const FeltPad pad = testing::fine_pad();
  const int columns = 6, rows = 14;
  const auto spread = [&](const std::vector<double>& counts) {
    std::vector<double> felt(counts.size(), 0.0);
    for (int i = 0; i < rows * columns; ++i) {
      for (const int dr : {-1, 0, 1}) {
        for (const int dc : {-1, 0, 1}) {
          const int r = i / columns + dr, c = i % columns + dc;
          if (r < 0 || c < 0 || r >= rows || c >= columns) continue;
          felt[r * columns + c] += counts[i] * std::pow(0.066, std::abs(dr) + std::abs(dc)) *
                                   std::pow(0.868, 2 - std::abs(dr) - std::abs(dc));
        }
      }
    }
    return felt;
  };
  for (const Hole& hole : {Hole(bars), Hole(square), Hole(bar), Hole(ring)}) {
    const auto counts =
        testing::pressed(pad, [&](double x, double y) { return hole(x - 0.001, y) ? 0.0 : 4e-4; });
    const auto ideal = imprint_of(pad, felt_texels(pad, counts))->pressed;
    const auto felt = imprint_of(pad, felt_texels(pad, spread(counts)))->pressed;
    for (std::size_t i = 0; i < ideal.size(); ++i) EXPECT_NEAR(felt[i], ideal[i], 0.1) << i;
  }
}

TEST(LearnedImprint, FindsWhereAPressLies) {
  // Taught by one press; the same one, moved, lies where it was moved.
  const std::vector<Imprint> taught = presses(bars, 12, 3);
  const LearnedImprint learned(taught);
  const Imprint& press = taught.front();
  const ImprintFit at = learned.fit(press);
  Imprint moved = press;
  const double turn = 0.7;
  const Eigen::Vector2d shift(0.001, -0.002);
  for (Eigen::Vector2d& p : moved.places) p = Eigen::Rotation2Dd(turn) * p + shift;
  const ImprintFit there = learned.fit(moved);
  EXPECT_NEAR(there.misfit, at.misfit, 0.1 * at.misfit + 0.5);
  const Eigen::Vector2d expected = Eigen::Rotation2Dd(turn) * at.placement.shift + shift;
  EXPECT_LT((there.placement.shift - expected).norm(), 0.001);
  EXPECT_EQ(learned.own_fits().size(), 12u);
}

TEST(LearnedImprint, OfSeveralPressesIsTheShapeFinerThanTexels) {
  const LearnedImprint learned(presses(square, 16, 5));
  double area = 0;  // m^2, of what does not press
  for (int row = 0; row < learned.cells(); ++row) {
    for (int column = 0; column < learned.cells(); ++column) {
      if (learned.known(row, column) > 1) area += 1e-6 * (1 - learned.likelihood(row, column));
    }
  }
  EXPECT_NEAR(area, 0.0168 * 0.0168, 0.25 * 0.0168 * 0.0168);
}

TEST(ImprintMemory, KnowsWhatItWasTaughtAndRefusesOthers) {
  ImprintMemory memory;
  EXPECT_THAT(memory.ask(presses(square, 1, 1)).reason, HasSubstr("nothing was taught"));
  memory.teach("cross", presses(bars, 12, 11));
  memory.teach("square", presses(square, 12, 12));
  memory.teach("bar", presses(bar, 12, 13));
  int right = 0;
  for (unsigned k = 0; k < 6; ++k) {
    right += memory.ask(presses(bars, 4, 100 + k)).name == "cross";
    right += memory.ask(presses(square, 4, 200 + k)).name == "square";
    right += memory.ask(presses(bar, 4, 300 + k)).name == "bar";
    right += memory.ask(presses(ring, 4, 400 + k)).name.empty();
  }
  EXPECT_GE(right, 23) << "of 24";
  const Recognised answer = memory.ask(presses(ring, 4, 500));
  ASSERT_EQ(answer.candidates.size(), 3u);
  EXPECT_GT(answer.candidates.front().misfit, 1);
  EXPECT_THAT(answer.reason, HasSubstr("it is likest"));
  EXPECT_TRUE(memory.forget("square"));
  EXPECT_FALSE(memory.forget("square"));
  EXPECT_NE(memory.ask(presses(square, 4, 600)).name, "square");
}

TEST(ImprintMemory, RefusesBadInput) {
  EXPECT_THROW(LearnedImprint({}), std::invalid_argument);
  EXPECT_THROW(LearnedImprint(presses(bar, 2, 1), {.cell = 0}), std::invalid_argument);
  EXPECT_THROW(LearnedImprint(presses(bar, 2, 1), {.sweeps = 0}), std::invalid_argument);
  EXPECT_THROW(LearnedImprint(presses(bar, 2, 1), {.contrast = 0}), std::invalid_argument);
  EXPECT_THROW(ImprintMemory({}, -1), std::invalid_argument);
  ImprintMemory memory;
  EXPECT_THROW(memory.ask({}), std::invalid_argument);
  memory.teach("bar", presses(bar, 2, 1));
  EXPECT_THROW(memory.judge({}), std::invalid_argument);
  EXPECT_THROW(memory.judge({{{"another", {}}}}), std::invalid_argument);
}

TEST(ImprintMemory, JudgesTheFitsThatItWouldFindItself) {
  ImprintMemory memory;
  memory.teach("cross", presses(bars, 6, 11));
  memory.teach("square", LearnedImprint(presses(square, 6, 12)));
  const std::vector<Imprint> question = presses(square, 2, 13);
  const Recognised asked = memory.ask(question);
  std::vector<ImprintMemory::Fits> fits{memory.fits(question[0]), memory.fits(question[1])};
  fits[0]["of no interest"] = {};
  const Recognised judged = memory.judge(fits);
  EXPECT_EQ(judged.name, "square");
  EXPECT_EQ(judged.name, asked.name);
  ASSERT_EQ(judged.candidates.size(), 2u);
  EXPECT_EQ(judged.candidates[0].misfit, asked.candidates[0].misfit);
}

}  // namespace
}  // namespace prehend::touch
