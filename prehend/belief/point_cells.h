#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

namespace prehend::belief {

/// Points in cubic cells, to find those that are near a place.
class PointCells {
 public:
  /// `points` outlive it. @pre distance > 0 [m].
  PointCells(const std::vector<Eigen::Vector3f>& points, double distance)
      : points_(points), side_(static_cast<float>(distance)) {
    for (std::size_t i = 0; i < points.size(); ++i) cells_[key(cell(points[i]))].push_back(i);
  }

  /// Calls visit(index, squared distance) for the points within the distance of `p`, in an order
  /// that is always the same.
  template <class Visit>
  void each_near(const Eigen::Vector3f& p, const Visit& visit) const {
    const Eigen::Vector3i center = cell(p);
    for (int neighbor = 0; neighbor < 27; ++neighbor) {
      const Eigen::Vector3i step(neighbor % 3 - 1, neighbor / 3 % 3 - 1, neighbor / 9 - 1);
      const auto found = cells_.find(key(center + step));
      if (found == cells_.end()) continue;
      for (const std::size_t i : found->second) {
        const float squared = (points_[i] - p).squaredNorm();
        if (squared < side_ * side_) visit(i, squared);
      }
    }
  }

 private:
  Eigen::Vector3i cell(const Eigen::Vector3f& p) const {
    return (p / side_).array().floor().matrix().cast<int>();
  }
  static std::uint64_t key(const Eigen::Vector3i& cell) {
    std::uint64_t key = 0;
    for (const int index : cell) {
      key = key << 21 | (static_cast<std::uint64_t>(static_cast<std::uint32_t>(index)) & 0x1FFFFF);
    }
    return key;
  }

  const std::vector<Eigen::Vector3f>& points_;
  float side_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;
};

}  // namespace prehend::belief
