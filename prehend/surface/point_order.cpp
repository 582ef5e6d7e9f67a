#include "prehend/surface/point_order.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <Eigen/Geometry>

namespace prehend::surface {
namespace {

constexpr int kDigitBits = 11;

struct Keyed {
  std::uint64_t key;
  int index;
};

/// By the three digits of the keys, the least significant one first.
void radix_sort(std::vector<Keyed>& items) {
  constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;
  std::vector<Keyed> other(items.size());
  for (int shift = 0; shift < 3 * kDigitBits; shift += kDigitBits) {
    std::array<std::size_t, kDigits + 1> start{};
    for (const Keyed& item : items) ++start[(item.key >> shift & (kDigits - 1)) + 1];
    for (std::size_t digit = 0; digit < kDigits; ++digit) start[digit + 1] += start[digit];
    for (const Keyed& item : items) other[start[item.key >> shift & (kDigits - 1)]++] = item;
    items.swap(other);
  }
}

std::array<float, 6> coordinates(const std::vector<Eigen::Vector3f>& points,
                                 const std::vector<Eigen::Vector3f>& attributes, int i) {
  std::array<float, 6> all{points[i].x(), points[i].y(), points[i].z(), 0, 0, 0};
  if (!attributes.empty()) {
    for (int k = 0; k < 3; ++k) all[3 + k] = attributes[i][k];
  }
  return all;
}

}  // namespace

std::vector<int> canonical_order(const std::vector<Eigen::Vector3f>& points,
                                 const std::vector<Eigen::Vector3f>& attributes) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : points) box.extend(p);
  // 11 bits for each axis; points in the same cell are few, and compared.
  const double extent = points.empty() ? 0 : box.sizes().cast<double>().maxCoeff();
  const double scale = extent > 0 ? 2047.99 / extent : 0;
  Eigen::Vector3d least = Eigen::Vector3d::Zero();
  if (!points.empty()) least = box.min().cast<double>();
  std::vector<Keyed> items(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::uint64_t key = 0;
    for (int axis = 2; axis >= 0; --axis) {
      key = key << kDigitBits | static_cast<std::uint64_t>(
                                    (static_cast<double>(points[i][axis]) - least[axis]) * scale);
    }
    items[i] = {key, static_cast<int>(i)};
  }
  radix_sort(items);
  for (std::size_t begin = 0, end = 0; begin < items.size(); begin = end) {
    for (end = begin + 1; end < items.size() && items[end].key == items[begin].key;) ++end;
    if (end - begin == 1) continue;
    std::sort(items.begin() + begin, items.begin() + end, [&](const Keyed& a, const Keyed& b) {
      return coordinates(points, attributes, a.index) < coordinates(points, attributes, b.index);
    });
  }
  std::vector<int> order(points.size());
  for (std::size_t i = 0; i < items.size(); ++i) order[i] = items[i].index;
  return order;
}

}  // namespace prehend::surface
