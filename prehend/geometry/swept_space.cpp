#include "prehend/geometry/swept_space.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace prehend::geometry {

SweptSpace::SweptSpace(const Eigen::AlignedBox3d& box, double spacing)
    : box_(box), spacing_(spacing) {
  constexpr double kMostVoxels = 1.6e7;
  if (box.isEmpty() || !box.sizes().allFinite()) {
    throw std::invalid_argument("SweptSpace: the box is empty or not finite");
  }
  if (!(spacing > 0) || !std::isfinite(spacing)) {
    throw std::invalid_argument("SweptSpace: the spacing must be > 0");
  }
  const Eigen::Array3d count = (box.sizes().array() / spacing).ceil().max(1);
  if (!(count.prod() <= kMostVoxels)) {
    throw std::invalid_argument("SweptSpace: the spacing is far too small for the box");
  }
  size_ = count.matrix().cast<int>();
  depths_.assign(static_cast<std::size_t>(count.prod()), -1e30f);
}

void SweptSpace::add_ball(const Eigen::Vector3d& center, double radius) {
  if (!(radius > 0) || !center.allFinite()) return;
  // Voxels just outside carry how far out they are, so that between the two the depth is 0 at the
  // ball's surface.
  const double reach = radius + 1.8 * spacing_;
  const Eigen::Array3d from = (center.array() - reach - box_.min().array()) / spacing_ - 0.5;
  const Eigen::Array3d to = (center.array() + reach - box_.min().array()) / spacing_ - 0.5;
  const Eigen::Array3d last = size_.cast<double>().array() - 1;
  if ((to < 0).any() || (from > last).any()) return;
  const Eigen::Vector3i first = from.ceil().max(0).matrix().cast<int>();
  const Eigen::Vector3i end = to.floor().min(last).matrix().cast<int>();
  for (int z = first.z(); z <= end.z(); ++z) {
    for (int y = first.y(); y <= end.y(); ++y) {
      for (int x = first.x(); x <= end.x(); ++x) {
        const auto depth = static_cast<float>(radius - (this->center(x, y, z) - center).norm());
        float& deepest = depths_[index(x, y, z)];
        deepest = std::max(deepest, depth);
      }
    }
  }
  empty_ = false;
}

void SweptSpace::add_path(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius) {
  const double step = std::max(0.5 * spacing_, 0.2 * radius);
  const int steps = static_cast<int>(std::ceil(std::min(1e6, (to - from).norm() / step)));
  for (int i = 0; i <= steps; ++i) {
    add_ball(from + (steps > 0 ? static_cast<double>(i) / steps : 0) * (to - from), radius);
  }
}

void SweptSpace::add(const SweptSpace& other) {
  if (other.size_ != size_ || !other.box_.isApprox(box_) || other.spacing_ != spacing_) {
    throw std::invalid_argument("SweptSpace: spaces of other voxels cannot be added");
  }
  for (std::size_t i = 0; i < depths_.size(); ++i) {
    depths_[i] = std::max(depths_[i], other.depths_[i]);
  }
  empty_ = empty_ && other.empty_;
}

double SweptSpace::depth(const Eigen::Vector3d& p) const {
  if (empty_) return 0;
  const Eigen::Array3d at = (p - box_.min()).array() / spacing_ - 0.5;
  if (!(at >= 0).all() || !(at < size_.cast<double>().array() - 1).all()) return 0;
  const Eigen::Vector3i cell = at.matrix().cast<int>();
  const Eigen::Array3d share = at - cell.cast<double>().array();
  double depth = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
    const double weight = (dx ? share.x() : 1 - share.x()) * (dy ? share.y() : 1 - share.y()) *
                          (dz ? share.z() : 1 - share.z());
    const float value = depths_[index(cell.x() + dx, cell.y() + dy, cell.z() + dz)];
    depth += weight * std::max(static_cast<double>(value), -spacing_);
  }
  return std::max(depth, 0.0);
}

}  // namespace prehend::geometry
