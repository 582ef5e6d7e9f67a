#include "prehend/surface/outline.h"

#include <algorithm>
#include <numeric>

namespace prehend::surface {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

std::vector<int> convex_outline(const std::vector<Eigen::Vector2d>& points) {
  if (points.size() < 3) return {};
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    const Eigen::Vector2d& a = points[i];
    const Eigen::Vector2d& b = points[j];
    if (a.x() != b.x()) return a.x() < b.x();
    return a.y() != b.y() ? a.y() < b.y() : i < j;
  });
  std::vector<int> hull;
  const auto add_chain = [&](auto begin, auto end) {
    const std::size_t least = hull.size() + 2;
    for (auto i = begin; i != end; ++i) {
      while (hull.size() >= least && cross(points[hull.back()] - points[hull[hull.size() - 2]],
                                           points[*i] - points[hull.back()]) <= 0) {
        hull.pop_back();
      }
      hull.push_back(*i);
    }
    hull.pop_back();  // the other chain starts with it
  };
  add_chain(order.begin(), order.end());
  add_chain(order.rbegin(), order.rend());
  if (hull.size() < 3) return {};
  return hull;
}

bool contains(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& p) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& a = outline[i];
    const Eigen::Vector2d& b = outline[(i + 1) % outline.size()];
    if (cross(b - a, p - a) < 0) return false;
  }
  return !outline.empty();
}

}  // namespace prehend::surface
