#include "prehend/surface/outline.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace prehend::surface {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

constexpr int kDirections = 8;  // and their opposites

/// The points that are not strictly inside the polygon of those farthest out in 16 directions: all
/// that can be on the outline (Akl and Toussaint, "A fast convex hull algorithm", 1978).
std::vector<int> outer_points(const std::vector<Eigen::Vector2d>& points) {
  constexpr double kPi = 3.141592653589793;
  std::array<int, 2 * kDirections> farthest{};
  for (int k = 0; k < kDirections; ++k) {
    const Eigen::Vector2d along(std::cos(kPi * k / kDirections), std::sin(kPi * k / kDirections));
    double most = along.dot(points[0]), least = most;
    for (std::size_t i = 1; i < points.size(); ++i) {
      const double reach = along.dot(points[i]);
      if (reach > most) {
        most = reach;
        farthest[k] = static_cast<int>(i);
      }
      if (reach < least) {
        least = reach;
        farthest[k + kDirections] = static_cast<int>(i);
      }
    }
  }
  std::vector<Eigen::Vector2d> corners;
  for (const int i : farthest) {
    if (corners.empty() || corners.back() != points[i]) corners.push_back(points[i]);
  }
  if (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
  std::vector<int> outer;
  for (std::size_t i = 0; i < points.size(); ++i) {
    bool inside = corners.size() > 2;
    for (std::size_t k = 0; inside && k < corners.size(); ++k) {
      const Eigen::Vector2d& from = corners[k];
      const Eigen::Vector2d& to = corners[k + 1 < corners.size() ? k + 1 : 0];
      inside = cross(to - from, points[i] - from) > 0;
    }
    if (!inside) outer.push_back(static_cast<int>(i));
  }
  return outer;
}

}  // namespace

std::vector<int> convex_outline(const std::vector<Eigen::Vector2d>& points) {
  if (points.size() < 3) return {};
  std::vector<int> order = outer_points(points);
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
