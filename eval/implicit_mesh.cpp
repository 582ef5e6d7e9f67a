#include "eval/implicit_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <unordered_map>
#include <vector>

#include "prehend/geometry/errors.h"

namespace prehend::eval {
namespace {

constexpr double kMostGridPoints = 1e8;

// The grid and the surface's vertices on its edges.
class TetrahedraMarcher {
 public:
  TetrahedraMarcher(const Implicit& solid, const Eigen::AlignedBox3d& box, double cell)
      : origin_(box.min()), cell_(cell) {
    double points = 1;
    for (int k = 0; k < 3; ++k) {
      const double count = std::ceil(box.sizes()[k] / cell) + 1;
      points *= count;
      if (!(points <= kMostGridPoints))
        throw std::invalid_argument("mesh_of: the cell is too small");
      count_[k] = static_cast<std::int64_t>(count);
    }
    values_.resize(static_cast<std::size_t>(points));
    bool any_inside = false;
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(values_.size()); ++i) {
      double value = solid(position(i));
      // The surface never passes through a grid point, so that no triangle collapses.
      if (!(std::abs(value) > 1e-6 * cell)) value = 1e-6 * cell;
      values_[static_cast<std::size_t>(i)] = value;
      if (value >= 0) continue;
      any_inside = true;
      if (on_border(i)) {
        throw geometry::InputError("The solid reaches out of the box it is meshed in",
                                   "Pass a larger box");
      }
    }
    if (!any_inside) {
      throw geometry::InputError("The solid has no inside within the box",
                                 "Pass a smaller cell or the solid's own box");
    }
  }

  geometry::TriangleMesh march() {
    // The six tetrahedra round the cube's diagonal 0-7; bit 0, 1, 2 of a corner: +x, +y, +z.
    static constexpr std::array<std::array<int, 4>, 6> kTetrahedra = {
        {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};
    for (std::int64_t z = 0; z + 1 < count_[2]; ++z) {
      for (std::int64_t y = 0; y + 1 < count_[1]; ++y) {
        for (std::int64_t x = 0; x + 1 < count_[0]; ++x) {
          std::array<std::int64_t, 8> corners;
          int inside = 0;
          for (int c = 0; c < 8; ++c) {
            corners[c] = index(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
            inside += value(corners[c]) < 0;
          }
          if (inside == 0 || inside == 8) continue;
          for (const auto& t : kTetrahedra) {
            cut({corners[t[0]], corners[t[1]], corners[t[2]], corners[t[3]]});
          }
        }
      }
    }
    return std::move(mesh_);
  }

 private:
  std::int64_t index(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return (z * count_[1] + y) * count_[0] + x;
  }
  std::array<std::int64_t, 3> coordinates(std::int64_t i) const {
    return {i % count_[0], i / count_[0] % count_[1], i / (count_[0] * count_[1])};
  }
  Eigen::Vector3d position(std::int64_t i) const {
    const auto c = coordinates(i);
    return origin_ + cell_ * Eigen::Vector3d(static_cast<double>(c[0]), static_cast<double>(c[1]),
                                             static_cast<double>(c[2]));
  }
  bool on_border(std::int64_t i) const {
    const auto c = coordinates(i);
    for (int k = 0; k < 3; ++k) {
      if (c[k] == 0 || c[k] + 1 == count_[k]) return true;
    }
    return false;
  }
  double value(std::int64_t i) const { return values_[static_cast<std::size_t>(i)]; }

  // The vertex where the surface crosses the edge between an inner and an outer grid point.
  int vertex(std::int64_t inner, std::int64_t outer) {
    const std::int64_t low = std::min(inner, outer), high = std::max(inner, outer);
    const auto key = static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint64_t>(high);
    const auto [found, is_new] = vertices_.emplace(key, static_cast<int>(mesh_.vertices.size()));
    if (is_new) {
      const double t = value(inner) / (value(inner) - value(outer));
      mesh_.vertices.push_back((1 - t) * position(inner) + t * position(outer));
    }
    return found->second;
  }

  // Turned so that it faces from `inside` to `outside`.
  void add_triangle(int a, int b, int c, const Eigen::Vector3d& outward) {
    const Eigen::Vector3d& p = mesh_.vertices[a];
    const Eigen::Vector3d normal = (mesh_.vertices[b] - p).cross(mesh_.vertices[c] - p);
    if (normal.dot(outward) < 0) std::swap(b, c);
    mesh_.triangles.emplace_back(a, b, c);
  }

  void cut(const std::array<std::int64_t, 4>& corners) {
    std::vector<std::int64_t> in, out;
    for (const std::int64_t c : corners) (value(c) < 0 ? in : out).push_back(c);
    if (in.empty() || out.empty()) return;
    Eigen::Vector3d outward = Eigen::Vector3d::Zero();
    for (const std::int64_t c : out) outward += position(c) / static_cast<double>(out.size());
    for (const std::int64_t c : in) outward -= position(c) / static_cast<double>(in.size());
    if (in.size() == 1) {
      add_triangle(vertex(in[0], out[0]), vertex(in[0], out[1]), vertex(in[0], out[2]), outward);
    } else if (out.size() == 1) {
      add_triangle(vertex(in[0], out[0]), vertex(in[1], out[0]), vertex(in[2], out[0]), outward);
    } else {
      const int a = vertex(in[0], out[0]), b = vertex(in[0], out[1]);
      const int c = vertex(in[1], out[1]), d = vertex(in[1], out[0]);
      add_triangle(a, b, c, outward);
      add_triangle(a, c, d, outward);
    }
  }

  Eigen::Vector3d origin_;
  double cell_;
  std::array<std::int64_t, 3> count_{};
  std::vector<double> values_;
  std::unordered_map<std::uint64_t, int> vertices_;
  geometry::TriangleMesh mesh_;
};

double segment_distance(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                        const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double t = std::clamp((p - a).dot(along) / std::max(along.squaredNorm(), 1e-30), 0.0, 1.0);
  return (p - a - t * along).norm();
}

}  // namespace

geometry::TriangleMesh mesh_of(const Implicit& solid, const Eigen::AlignedBox3d& box, double cell) {
  if (!(cell > 0) || box.isEmpty() || !box.sizes().allFinite()) {
    throw std::invalid_argument("mesh_of: the box must not be empty and the cell positive");
  }
  return TetrahedraMarcher(solid, box, cell).march();
}

namespace solids {

double rounded_box(const Eigen::Vector3d& p, const Eigen::Vector3d& center,
                   const Eigen::Vector3d& size, double radius) {
  const Eigen::Vector3d q =
      (p - center).cwiseAbs() - (0.5 * size - Eigen::Vector3d::Constant(radius));
  return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0) - radius;
}

double cone_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                    double radius_a, double radius_b) {
  const Eigen::Vector3d along = b - a;
  const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - a - t * along).norm() - (radius_a + t * (radius_b - radius_a));
}

double ellipsoid(const Eigen::Vector3d& p, const Eigen::Vector3d& center,
                 const Eigen::Vector3d& radii) {
  const Eigen::Vector3d q = p - center;
  const double norm = q.cwiseQuotient(radii).norm();
  const double gradient = q.cwiseQuotient(radii.cwiseAbs2()).norm();
  return gradient > 1e-9 ? norm * (norm - 1) / gradient : -radii.minCoeff();
}

double torus(const Eigen::Vector3d& p, const Eigen::Vector3d& center, const Eigen::Vector3d& axis,
             double major, double minor) {
  const double height = (p - center).dot(axis);
  const double radius = (p - center - height * axis).norm();
  return std::hypot(radius - major, height) - minor;
}

double revolution(const Eigen::Vector3d& p, const std::vector<Eigen::Vector2d>& outline) {
  const Eigen::Vector2d q(std::hypot(p.x(), p.y()), p.z());
  double distance = std::numeric_limits<double>::infinity();
  bool inside = false;
  for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
    const Eigen::Vector2d &a = outline[j], &b = outline[i];
    // An edge on the axis bounds the polygon, not the solid.
    if (a.x() > 0 || b.x() > 0) distance = std::min(distance, segment_distance(q, a, b));
    if ((a.y() > q.y()) != (b.y() > q.y()) &&
        q.x() < a.x() + (q.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) {
      inside = !inside;
    }
  }
  return inside ? -distance : distance;
}

}  // namespace solids
}  // namespace prehend::eval
