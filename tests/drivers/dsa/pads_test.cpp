#include "drivers/dsa/node/pads.h"

#include <gtest/gtest.h>

#include <numeric>
#include <stdexcept>

namespace prehend::drivers::dsa {
namespace {

// Two matrices of 2 x 3 (x, y); counts 0 to 11.
const std::vector<MatrixInfo> kMatrices = [] {
  MatrixInfo matrix;
  matrix.texel_width = 3.4F;
  matrix.texel_height = 3.5F;
  matrix.cells_x = 2;
  matrix.cells_y = 3;
  return std::vector<MatrixInfo>{matrix, matrix};
}();

Frame counting() {
  Frame frame{7, std::vector<std::uint16_t>(12)};
  std::iota(frame.texels.begin(), frame.texels.end(), std::uint16_t{0});
  return frame;
}

std::vector<std::uint32_t> counts(const Pad& pad) {
  const auto message = pad_message(pad, counting(), kMatrices, 5);
  return {message.intensity().begin(), message.intensity().end()};
}

TEST(DsaPads, TakesItsMatrixAndTurnsIt) {
  using Counts = std::vector<std::uint32_t>;
  EXPECT_EQ(counts({"left", 0}), (Counts{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(counts({"right", 1}), (Counts{6, 7, 8, 9, 10, 11}));
  EXPECT_EQ(counts({"left", 0, true, false}), (Counts{4, 5, 2, 3, 0, 1}));
  EXPECT_EQ(counts({"left", 0, false, true}), (Counts{1, 0, 3, 2, 5, 4}));
  EXPECT_EQ(counts({"left", 0, true, true}), (Counts{5, 4, 3, 2, 1, 0}));
}

TEST(DsaPads, HasUnitsAndASum) {
  const auto message = pad_message({"left", 1, false, false, 0.5}, counting(), kMatrices, 5);
  EXPECT_EQ(message.header().stamp(), 5);
  EXPECT_EQ(message.header().frame_id(), "left_pad");
  EXPECT_EQ(message.rows(), 3u);
  EXPECT_EQ(message.columns(), 2u);
  EXPECT_NEAR(message.texel_width(), 0.0034, 1e-9);
  EXPECT_NEAR(message.texel_height(), 0.0035, 1e-9);
  EXPECT_EQ(message.full_scale(), 4095u);
  EXPECT_NEAR(message.sum(), 0.5 * (6 + 7 + 8 + 9 + 10 + 11), 1e-12);
}

TEST(DsaPads, CorrectsByItsCalibration) {
  robot::PadCalibration calibration;
  calibration.rows = 3;
  calibration.columns = 2;
  calibration.newton_per_count = 0.25;
  calibration.gains = {2, 1, 0.5, 0, 1, 1};
  calibration.zeros = {0, 0, 2, 0, 20, 0};
  Pad pad{"left", 1};
  pad.calibration = calibration;
  EXPECT_EQ(counts(pad), (std::vector<std::uint32_t>{3, 7, 12, 0, 0, 11}));
  const auto message = pad_message(pad, counting(), kMatrices, 5);
  EXPECT_EQ(message.newton_per_count(), 0.25);
  EXPECT_NEAR(message.sum(), 0.25 * (3 + 7 + 12 + 11), 1e-12);
  // It is of the pad as published: turned, the same texel has the same gain.
  pad.flip_rows = pad.flip_columns = true;
  EXPECT_EQ(counts(pad), (std::vector<std::uint32_t>{6, 10, 14, 0, 0, 6}));
  Frame full = counting();
  full.texels[6] = kFullScale;
  pad.flip_rows = pad.flip_columns = false;
  EXPECT_EQ(pad_message(pad, full, kMatrices, 0).intensity(0), kFullScale) << "stays full";
  pad.calibration->rows = 4;
  EXPECT_THROW(pad_message(pad, counting(), kMatrices, 0), std::invalid_argument);
}

TEST(DsaPads, RefusesMatricesThatAreNotThere) {
  EXPECT_THROW(pad_message({"left", 2}, counting(), kMatrices, 0), std::invalid_argument);
  Frame cut = counting();
  cut.texels.resize(11);
  EXPECT_THROW(pad_message({"right", 1}, cut, kMatrices, 0), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::drivers::dsa
