#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "prehend/geometry/errors.h"
#include "prehend/surface/poisson.h"

namespace prehend::surface {
namespace {

using geometry::InputError;
using Outline = std::vector<Eigen::Vector2d>;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Convex hull, counter-clockwise, by Andrew's monotone chain (1979).
Outline convex_outline(Outline points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  Outline hull;
  const auto add_chain = [&](auto begin, auto end) {
    const std::size_t least = hull.size() + 2;
    for (auto p = begin; p != end; ++p) {
      while (hull.size() >= least &&
             cross(hull.back() - hull[hull.size() - 2], *p - hull.back()) <= 0) {
        hull.pop_back();
      }
      hull.push_back(*p);
    }
    hull.pop_back();  // the other chain starts with it
  };
  if (points.size() < 3) return {};
  add_chain(points.begin(), points.end());
  add_chain(points.rbegin(), points.rend());
  return hull.size() < 3 ? Outline{} : hull;
}

bool inside(const Outline& outline, const Eigen::Vector2d& p) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& a = outline[i];
    const Eigen::Vector2d& b = outline[(i + 1) % outline.size()];
    if (cross(b - a, p - a) < 0) return false;
  }
  return true;
}

}  // namespace

geometry::PointCloud close_bottom(const geometry::PointCloud& cloud, const geometry::Plane& table,
                                  double slice, double spacing) {
  if (cloud.normals.size() != cloud.size() || cloud.empty()) {
    throw InputError("the cloud has no points or no normals", "estimate normals first");
  }
  const Eigen::Vector3d up = table.normal;
  const Eigen::Vector3d x = up.unitOrthogonal();
  const Eigen::Vector3d y = up.cross(x);
  double top = 0;
  double lowest = 1e9;
  for (const Eigen::Vector3f& p : cloud.points) {
    const double height = table.signed_distance(p.cast<double>());
    top = std::max(top, height);
    lowest = std::min(lowest, height);
  }
  if (!(top > spacing) || lowest > top) {
    throw InputError("the completed shape does not rise above its table",
                     "check the table's plane and the side its normal points to");
  }
  lowest = std::max(lowest, 0.0);
  Outline slice_points;
  for (const Eigen::Vector3f& p : cloud.points) {
    const Eigen::Vector3d p_W = p.cast<double>();
    const double height = table.signed_distance(p_W);
    if (height <= lowest + slice * (top - lowest)) slice_points.emplace_back(x.dot(p_W), y.dot(p_W));
  }
  geometry::PointCloud closed = cloud;
  closed.colors.clear();
  const Outline outline = convex_outline(std::move(slice_points));
  if (outline.empty()) return closed;

  const auto add = [&](const Eigen::Vector2d& p, double height, const Eigen::Vector3d& normal) {
    const Eigen::Vector3d p_W = p.x() * x + p.y() * y + (table.offset + height) * up;
    closed.points.push_back(p_W.cast<float>());
    closed.normals.push_back(normal.cast<float>());
  };
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : outline) box.extend(p);
  for (double u = box.min().x() + 0.5 * spacing; u < box.max().x(); u += spacing) {
    for (double v = box.min().y() + 0.5 * spacing; v < box.max().y(); v += spacing) {
      if (inside(outline, {u, v})) add({u, v}, 0, -up);
    }
  }
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& a = outline[i];
    const Eigen::Vector2d side = outline[(i + 1) % outline.size()] - a;
    if (side.norm() < 1e-9 * spacing) continue;
    const Eigen::Vector2d out = Eigen::Vector2d(side.y(), -side.x()).normalized();
    const int steps = std::max(1, static_cast<int>(std::lround(side.norm() / spacing)));
    for (int step = 0; step < steps; ++step) {
      for (double height = 0.5 * spacing; height < lowest; height += spacing) {
        add(a + (step + 0.5) / steps * side, height, out.x() * x + out.y() * y);
      }
    }
  }
  return closed;
}

}  // namespace prehend::surface
