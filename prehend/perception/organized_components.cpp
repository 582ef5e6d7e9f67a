#include "prehend/perception/organized_components.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace prehend::perception {
namespace {

// Disjoint sets with path halving; the smaller index is the root, so the order of unions does not
// matter.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int root(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(int a, int b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

constexpr int kRound = 2;         // columns and rows that a point is judged by
constexpr int kLeastToJudge = 8;  // of the 24 pixels round it must have a point
constexpr int kLeastCompany = 2;  // of them are near to what is on a surface, be it a thread

bool is_flying(const geometry::PointCloud& cloud, int index, double tolerance) {
  const int u = index % cloud.width, v = index / cloud.width;
  const Eigen::Vector3f& p = cloud.points[index];
  const auto limit = static_cast<float>(tolerance * tolerance);
  int known = 0, near = 0;
  for (int y = std::max(0, v - kRound); y <= std::min(cloud.height - 1, v + kRound); ++y) {
    for (int x = std::max(0, u - kRound); x <= std::min(cloud.width - 1, u + kRound); ++x) {
      const Eigen::Vector3f& q = cloud.points[y * cloud.width + x];
      if ((x == u && y == v) || !geometry::is_finite(q)) continue;
      ++known;
      near += (q - p).squaredNorm() <= limit;
    }
  }
  return known >= kLeastToJudge && near < kLeastCompany;
}

}  // namespace

std::vector<int> without_flying_points(const geometry::PointCloud& cloud,
                                       const std::vector<int>& indices, double tolerance,
                                       double focal_length) {
  if (!cloud.organized()) {
    throw std::invalid_argument("without_flying_points: the cloud is not organized");
  }
  if (!(tolerance > 0)) {
    throw std::invalid_argument("without_flying_points: tolerance must be positive");
  }
  std::vector<int> kept;
  for (const int i : indices) {
    const double pixel = static_cast<double>(cloud.points[i].z()) / focal_length;
    if (!is_flying(cloud, i, tolerance + 2 * pixel)) kept.push_back(i);
  }
  return kept;
}

std::vector<std::vector<int>> organized_components(const geometry::PointCloud& cloud,
                                                   const std::vector<int>& indices,
                                                   double tolerance, int reach, int min_size) {
  if (!cloud.organized()) {
    throw std::invalid_argument("organized_components: the cloud is not organized");
  }
  if (reach < 1 || reach > 20 || !(tolerance > 0)) {
    throw std::invalid_argument("organized_components: reach must be 1..20 and tolerance positive");
  }
  // Position in `indices` of each pixel, -1: not named.
  std::vector<int> place(cloud.size(), -1);
  for (std::size_t k = 0; k < indices.size(); ++k) place[indices[k]] = static_cast<int>(k);
  DisjointSets sets(indices.size());
  const auto limit = static_cast<float>(tolerance * tolerance);
  for (std::size_t k = 0; k < indices.size(); ++k) {
    const int u = indices[k] % cloud.width, v = indices[k] / cloud.width;
    const Eigen::Vector3f& p = cloud.points[indices[k]];
    // Each pair once: the pixels to the right and below.
    for (int dv = 0; dv <= reach && v + dv < cloud.height; ++dv) {
      for (int du = dv == 0 ? 1 : -reach; du <= reach; ++du) {
        if (u + du < 0 || u + du >= cloud.width) continue;
        const int other = place[indices[k] + dv * cloud.width + du];
        if (other < 0) continue;
        if ((cloud.points[indices[other]] - p).squaredNorm() <= limit) {
          sets.unite(static_cast<int>(k), other);
        }
      }
    }
  }
  std::vector<std::vector<int>> groups(indices.size());
  for (std::size_t k = 0; k < indices.size(); ++k) {
    groups[sets.root(static_cast<int>(k))].push_back(indices[k]);
  }
  std::erase_if(groups, [min_size](const std::vector<int>& group) {
    return group.empty() || group.size() < static_cast<std::size_t>(std::max(min_size, 1));
  });
  for (std::vector<int>& group : groups) std::sort(group.begin(), group.end());
  std::sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) {
    return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front();
  });
  return groups;
}

}  // namespace prehend::perception
