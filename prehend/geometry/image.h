#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace prehend::geometry {

/// A row-major image without padding: pixel (u, v) = column u, row v is data[v * width + u].
template <typename T>
struct Image {
  int width = 0;
  int height = 0;
  std::vector<T> data;  // width * height

  Image() = default;
  Image(int width_in, int height_in, T fill = T{})
      : width(width_in),
        height(height_in),
        data(static_cast<std::size_t>(width_in) * static_cast<std::size_t>(height_in), fill) {}

  bool empty() const { return data.empty(); }
  bool contains(int u, int v) const { return u >= 0 && v >= 0 && u < width && v < height; }
  T& at(int u, int v) { return data[static_cast<std::size_t>(v) * width + u]; }
  const T& at(int u, int v) const { return data[static_cast<std::size_t>(v) * width + u]; }
};

using Rgb = std::array<std::uint8_t, 3>;  // red, green, blue
using ColorImage = Image<Rgb>;
using MaskImage = Image<std::uint8_t>;  // 0 outside, 255 inside
using DepthImage = Image<float>;        // z along the optical axis [m], NaN where unknown

}  // namespace prehend::geometry
