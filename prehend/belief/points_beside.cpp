#include "prehend/belief/points_beside.h"

#include <array>
#include <map>

#include <Eigen/Geometry>

#include "prehend/belief/point_cells.h"

namespace prehend::belief {
namespace {

constexpr double kSeenAlready = 0.006;  // m

}  // namespace

std::vector<std::size_t> points_beside(const geometry::PointCloud& cloud,
                                       const geometry::PointCloud& known, std::size_t most) {
  if (most == 0) return {};
  const PointCells cells(known.points, kSeenAlready);
  std::vector<std::size_t> left;
  Eigen::AlignedBox3f box;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    bool is_seen = false;
    cells.each_near(cloud.points[i], [&](std::size_t, float) { is_seen = true; });
    if (is_seen) continue;
    left.push_back(i);
    box.extend(cloud.points[i]);
  }
  if (left.size() <= most) return left;
  // One of each cell, of cells that grow until they are few enough.
  for (float side = box.sizes().maxCoeff() / 32;; side *= 1.2F) {
    std::map<std::array<int, 3>, std::size_t> chosen;
    for (const std::size_t i : left) {
      const Eigen::Array3i cell =
          ((cloud.points[i] - box.min()) / side).array().floor().cast<int>();
      chosen.try_emplace({cell.x(), cell.y(), cell.z()}, i);
    }
    if (chosen.size() > most) continue;
    std::vector<std::size_t> few;
    for (const auto& [cell, i] : chosen) few.push_back(i);
    return few;
  }
}

}  // namespace prehend::belief
