#include "prehend/contact/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "prehend/contact/mesh_rays.h"
#include "prehend/contact/require.h"

namespace prehend::contact {
namespace {

constexpr double kNoHit = std::numeric_limits<double>::infinity();

// The part of a line that is inside a convex solid; empty when enter > exit.
struct Interval {
  double enter = -kNoHit, exit = kNoHit;
};

Interval intersection(const Interval& a, const Interval& b) {
  return {std::max(a.enter, b.enter), std::min(a.exit, b.exit)};
}

// |o + t d| <= half.
Interval slab(double o, double d, double half) {
  if (d == 0) return std::abs(o) <= half ? Interval{} : Interval{1, 0};
  const double a = (-half - o) / d, b = (half - o) / d;
  return {std::min(a, b), std::max(a, b)};
}

// a t^2 + 2 b t + c <= 0 with a >= 0.
Interval quadratic(double a, double b, double c) {
  if (a == 0) return c <= 0 ? Interval{} : Interval{1, 0};
  const double discriminant = b * b - a * c;
  if (discriminant < 0) return {1, 0};
  // The root of larger magnitude first, the other from the product: no cancellation.
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  const double r1 = q / a, r2 = q != 0 ? c / q : 0.0;
  return {std::min(r1, r2), std::max(r1, r2)};
}

Interval ball(const Eigen::Vector3d& o, const Eigen::Vector3d& d, double radius) {
  return quadratic(d.squaredNorm(), o.dot(d), o.squaredNorm() - radius * radius);
}

Interval tube(const Eigen::Vector3d& o, const Eigen::Vector3d& d, double radius, double half) {
  const Eigen::Vector2d p = o.head<2>(), v = d.head<2>();
  return intersection(quadratic(v.squaredNorm(), p.dot(v), p.squaredNorm() - radius * radius),
                      slab(o.z(), d.z(), half));
}

// The first t >= 0 inside.
double entry(const Interval& inside) {
  if (inside.enter > inside.exit || inside.exit < 0) return kNoHit;
  return std::max(0.0, inside.enter);
}

}  // namespace

Shape Shape::box(const Eigen::Vector3d& size) {
  for (int axis = 0; axis < 3; ++axis) require_positive(size[axis], "Shape: box size");
  Shape shape;
  shape.kind_ = Kind::kBox;
  shape.half_ = 0.5 * size;
  shape.bounds_ = {-shape.half_, shape.half_};
  return shape;
}

Shape Shape::sphere(double radius) {
  require_positive(radius, "Shape: radius");
  Shape shape;
  shape.kind_ = Kind::kSphere;
  shape.radius_ = radius;
  shape.half_.setConstant(radius);
  shape.bounds_ = {-shape.half_, shape.half_};
  return shape;
}

Shape Shape::cylinder(double radius, double length) {
  require_positive(radius, "Shape: radius");
  require_positive(length, "Shape: length");
  Shape shape;
  shape.kind_ = Kind::kCylinder;
  shape.radius_ = radius;
  shape.half_ = Eigen::Vector3d(radius, radius, 0.5 * length);
  shape.bounds_ = {-shape.half_, shape.half_};
  return shape;
}

Shape Shape::capsule(double radius, double length) {
  Shape shape = cylinder(radius, length);
  shape.kind_ = Kind::kCapsule;
  const Eigen::Vector3d reach = shape.half_ + Eigen::Vector3d(0, 0, radius);
  shape.bounds_ = {-reach, reach};
  return shape;
}

Shape Shape::half_space() {
  Shape shape;
  shape.kind_ = Kind::kHalfSpace;
  return shape;
}

Shape Shape::mesh(geometry::TriangleMesh mesh_B) {
  Shape shape;
  shape.kind_ = Kind::kMesh;
  shape.bounds_ = geometry::bounds(mesh_B);
  shape.mesh_ = std::make_shared<const MeshRays>(std::move(mesh_B));
  return shape;
}

double Shape::ray_distance(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                           double limit) const {
  double distance = kNoHit;
  switch (kind_) {
    case Kind::kBox: {
      Interval inside;
      for (int axis = 0; axis < 3; ++axis) {
        inside = intersection(inside, slab(origin[axis], direction[axis], half_[axis]));
      }
      distance = entry(inside);
      break;
    }
    case Kind::kSphere:
      distance = entry(ball(origin, direction, radius_));
      break;
    case Kind::kCylinder:
      distance = entry(tube(origin, direction, radius_, half_.z()));
      break;
    case Kind::kCapsule: {
      const Eigen::Vector3d end(0, 0, half_.z());
      distance = std::min({entry(tube(origin, direction, radius_, half_.z())),
                           entry(ball(origin - end, direction, radius_)),
                           entry(ball(origin + end, direction, radius_))});
      break;
    }
    case Kind::kHalfSpace:
      if (origin.z() <= 0) return 0;
      if (direction.z() < 0) distance = -origin.z() / direction.z();
      break;
    case Kind::kMesh:
      return mesh_->first_hit(origin, direction, limit);
  }
  return distance <= limit ? distance : kNoHit;
}

double Shape::depth_inside(const Eigen::Vector3d& p, Eigen::Vector3d& normal) const {
  // Away from a point or an axis; on it, any direction is as good.
  const auto from = [&](const Eigen::Vector3d& away) {
    const double distance = away.norm();
    normal = distance > 0 ? Eigen::Vector3d(away / distance) : Eigen::Vector3d::UnitX();
    return distance;
  };
  switch (kind_) {
    case Kind::kBox: {
      int nearest = 0;
      const Eigen::Vector3d depths = half_ - p.cwiseAbs();
      const double depth = depths.minCoeff(&nearest);
      normal = std::copysign(1.0, p[nearest]) * Eigen::Vector3d::Unit(nearest);
      return depth;
    }
    case Kind::kSphere:
      return radius_ - from(p);
    case Kind::kCylinder: {
      const double around = radius_ - from({p.x(), p.y(), 0});
      const double end = half_.z() - std::abs(p.z());
      if (end < around) normal = std::copysign(1.0, p.z()) * Eigen::Vector3d::UnitZ();
      return std::min(around, end);
    }
    case Kind::kCapsule:
      return radius_ - from(p - Eigen::Vector3d(0, 0, std::clamp(p.z(), -half_.z(), half_.z())));
    case Kind::kHalfSpace:
      normal = Eigen::Vector3d::UnitZ();
      return -p.z();
    case Kind::kMesh:
      break;
  }
  throw std::logic_error("Shape::depth_inside: a mesh is asked by geometry::MeshQuery");
}

}  // namespace prehend::contact
