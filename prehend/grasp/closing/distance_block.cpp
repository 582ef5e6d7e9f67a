#include "prehend/grasp/closing/distance_block.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;

void store(const Vector3d& v, float (&to)[3]) {
  for (int k = 0; k < 3; ++k) to[k] = static_cast<float>(v[k]);
}

BlockTriangle prepare(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d corners[3] = {a, b, c};
  const Vector3d centroid = (a + b + c) / 3;
  const Vector3d cross = (b - a).cross(c - a);
  const double longest = std::max((b - a).squaredNorm(), (c - a).squaredNorm());
  BlockTriangle triangle;
  triangle.has_area = cross.squaredNorm() > 1e-20 * longest * longest;
  const Vector3d normal = triangle.has_area ? Vector3d(cross.normalized()) : Vector3d::Zero();
  store(normal, triangle.normal);
  store(centroid, triangle.centroid);
  double radius = 0;
  for (int k = 0; k < 3; ++k) {
    const Vector3d way = corners[(k + 1) % 3] - corners[k];
    const double squared = way.squaredNorm();
    BlockTriangle::Side& side = triangle.sides[k];
    store(corners[k], side.from);
    store(way, side.way);
    store(normal.cross(way).normalized(), side.inward);
    // A side shorter than single precision tells is a point.
    side.per_squared = squared > 1e-30 ? static_cast<float>(1 / squared) : 0;
    radius = std::max(radius, (corners[k] - centroid).norm());
  }
  triangle.radius = static_cast<float>(radius);
  return triangle;
}

}  // namespace

DistanceBlocks::DistanceBlocks(const geometry::SurfaceQuery& surface_W)
    : surface_W_(&surface_W), origin_W_(surface_W.box().center()) {
  const geometry::TriangleMesh& mesh = surface_W.mesh();
  triangles_.reserve(mesh.triangles.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const auto corner = [&](int k) {
      return Vector3d(mesh.vertices[static_cast<std::size_t>(t[k])] - origin_W_);
    };
    triangles_.push_back(prepare(corner(0), corner(1), corner(2)));
  }
}

DistanceBlock DistanceBlocks::measure(const Vector3d& first_W, double cell, double most) const {
  DistanceBlock block;
  block.fill(std::numeric_limits<float>::max());
  const double to_middle = (kBlockSide - 1) * cell / 2;  // along each axis
  const Vector3d middle_W = first_W.array() + to_middle;
  auto found = surface_W_->nearest(middle_W, most);
  if (!found) found = surface_W_->nearest(middle_W);
  if (!found) return block;
  // Whoever is nearest to some node is not farther from the middle than this.
  const double reach = found->distance + 2 * std::sqrt(3.0) * to_middle;
  thread_local std::vector<int> near;  // kept for its memory, as is the next
  thread_local std::vector<float> scratch;
  surface_W_->near_triangles(middle_W, reach, &near);
  scratch.resize(8 * near.size());
  BlockPlace place;
  store(first_W - origin_W_, place.first);
  place.cell = static_cast<float>(cell);
  place.most = static_cast<float>(found->distance);
  measure_block(triangles_, near, place, scratch.data(), block);
  return block;
}

}  // namespace prehend::grasp
