#include "drivers/dsa/node/pads.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace prehend::drivers::dsa {
namespace {

// A count in the calibration's unit; a full texel stays full, a dead one says nothing.
std::uint16_t corrected(const robot::PadCalibration& calibration, std::size_t texel,
                        std::uint16_t count) {
  const double gain = calibration.gains.empty() ? 1 : calibration.gains[texel];
  const double zero = calibration.zeros.empty() ? 0 : calibration.zeros[texel];
  if (gain == 0) return 0;
  if (count >= kFullScale) return kFullScale;
  return static_cast<std::uint16_t>(
      std::clamp(std::round((count - zero) / gain), 0.0, static_cast<double>(kFullScale)));
}

}  // namespace

msgs::TactileFrame pad_message(const Pad& pad, const Frame& frame,
                               const std::vector<MatrixInfo>& matrices, std::int64_t stamp) {
  if (pad.matrix >= matrices.size()) {
    throw std::invalid_argument("pad " + pad.name + " is to be matrix " +
                                std::to_string(pad.matrix) + ", but the controller has " +
                                std::to_string(matrices.size()));
  }
  std::size_t begin = 0;
  for (std::size_t i = 0; i < pad.matrix; ++i) {
    begin += std::size_t{matrices[i].cells_x} * matrices[i].cells_y;
  }
  const MatrixInfo& matrix = matrices[pad.matrix];
  const std::size_t rows = matrix.cells_y, columns = matrix.cells_x;
  if (begin + rows * columns > frame.texels.size()) {
    throw std::invalid_argument("a tactile frame is shorter than its matrices");
  }
  if (pad.calibration && (pad.calibration->rows != static_cast<int>(rows) ||
                          pad.calibration->columns != static_cast<int>(columns))) {
    throw std::invalid_argument(
        "the calibration of pad " + pad.name + " is of " + std::to_string(pad.calibration->rows) +
        " x " + std::to_string(pad.calibration->columns) + " texels, its matrix has " +
        std::to_string(rows) + " x " + std::to_string(columns));
  }
  msgs::TactileFrame message;
  message.mutable_header()->set_stamp(stamp);
  message.mutable_header()->set_frame_id(pad.name + "_pad");
  message.set_rows(static_cast<std::uint32_t>(rows));
  message.set_columns(static_cast<std::uint32_t>(columns));
  constexpr double kMillimetre = 1e-3;
  message.set_texel_width(matrix.texel_width * kMillimetre);
  message.set_texel_height(matrix.texel_height * kMillimetre);
  message.set_full_scale(kFullScale);
  message.mutable_intensity()->Reserve(static_cast<int>(rows * columns));
  std::uint64_t sum = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t y = pad.flip_rows ? rows - 1 - row : row;
    for (std::size_t column = 0; column < columns; ++column) {
      const std::size_t x = pad.flip_columns ? columns - 1 - column : column;
      std::uint16_t count = frame.texels[begin + y * columns + x];
      if (pad.calibration) count = corrected(*pad.calibration, row * columns + column, count);
      message.add_intensity(count);
      sum += count;
    }
  }
  const double newton = pad.calibration ? pad.calibration->newton_per_count : pad.newton_per_count;
  message.set_sum(static_cast<double>(sum) * newton);
  message.set_newton_per_count(newton);
  return message;
}

}  // namespace prehend::drivers::dsa
