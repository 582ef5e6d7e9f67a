#include "prehend/touch/felt_pad.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include "prehend/contact/texel.h"

namespace prehend::touch {

FeltPad felt_pad(const robot::TactilePadModel& model, bool mirrored) {
  robot::validate(model);
  return felt_pad({model.rows, model.columns, model.width(), model.length(), model.thickness},
                  model, mirrored);
}

FeltPad felt_pad(const contact::PadGrid& grid, const robot::TactilePadModel& model, bool mirrored) {
  FeltPad pad{contact::PadLayout::flat(grid), model.law, model.newton_per_count, model.full_scale};
  if (!mirrored) return pad;
  std::vector<std::size_t> order(pad.layout.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (int row = 0; row < grid.rows; ++row) {
    const auto begin = order.begin() + static_cast<std::ptrdiff_t>(row) * grid.columns;
    std::reverse(begin, begin + grid.columns);
  }
  pad.layout = pad.layout.reordered(order);
  return pad;
}

FeltTexels felt_texels(const FeltPad& pad, const std::vector<double>& counts) {
  if (counts.size() != pad.layout.size()) {
    throw std::invalid_argument("a frame of " + std::to_string(counts.size()) +
                                " counts for a pad of " + std::to_string(pad.layout.size()) +
                                " texels");
  }
  FeltTexels felt{std::vector<Texel>(counts.size(), Texel::kFree),
                  std::vector<double>(counts.size(), 0.0)};
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (!(pad.layout.scale[i] > 0)) continue;  // a place of a grid where the surface has no cell
    if (!std::isfinite(counts[i]) || counts[i] < 0) {
      felt.state[i] = Texel::kUnreadable;
    } else if (counts[i] > pad.threshold) {
      felt.state[i] = counts[i] >= pad.full_scale ? Texel::kFull : Texel::kTouched;
      felt.force[i] = counts[i] * pad.newton_per_count;
    }
  }
  return felt;
}

double rest_depth(const contact::TexelLaw& law, double scale, double force, double thickness) {
  if (!(force > 0)) return 0;
  double low = 0, high = thickness;
  const auto force_at = [&](double depth) { return scale * contact::normal_force(law, depth, 0); };
  if (force_at(high) <= force) return thickness;
  if (law.normal_law == contact::NormalLaw::kLinear) return force / (scale * law.stiffness);
  constexpr int kHalvings = 40;  // of 3 mm: 3e-15 m
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    (force_at(middle) < force ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace prehend::touch
