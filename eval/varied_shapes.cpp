#include "eval/varied_shapes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "eval/household_objects.h"
#include "eval/implicit_mesh.h"

namespace prehend::eval {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Outline = std::vector<Vector2d>;

constexpr double kThinnest = 0.005;       // m
constexpr double kLeastShare = 1.0 / 12;  // of the size
constexpr double kHighest = 0.4;          // m

double cell_of(double size) { return std::clamp(size / 90, 4e-4, 6e-3); }

// A wall that the grid resolves.
double wall_of(double size) { return std::max({0.003, size * 0.04, 2.5 * cell_of(size)}); }

std::shared_ptr<const geometry::TriangleMesh> meshed(const Implicit& solid, const Vector3d& low,
                                                     const Vector3d& high) {
  const double cell = cell_of((high - low).maxCoeff());
  const Vector3d margin = Vector3d::Constant(2 * cell);
  return std::make_shared<geometry::TriangleMesh>(
      standing(mesh_of(solid, {low - margin, high + margin}, cell)));
}

DrawnSolid turned(const Outline& outline) {
  double radius = 0, height = 0;
  for (const Vector2d& p : outline) {
    radius = std::max(radius, p.x());
    height = std::max(height, p.y());
  }
  return {meshed([&](const Vector3d& p) { return solids::revolution(p, outline); },
                 {-radius, -radius, 0}, {radius, radius, height}),
          true, true};
}

// An open vessel: a wall from the foot to the rim, a floor.
Outline vessel(double foot, double rim, double height, double wall) {
  return {{0, 0}, {foot, 0}, {rim, height}, {rim - wall, height}, {foot - wall, wall}, {0, wall}};
}

DrawnSolid vessel_of(double size, double lowest, double highest, double narrowest, Drawn& drawn) {
  const double flat = drawn.between(lowest, highest);  // height over width
  const double rim = flat > 1 ? size / flat / 2 : size / 2;
  const double height = std::min(2 * rim * flat, kHighest);
  const double wall = wall_of(size);
  const double foot = std::max(rim * drawn.between(narrowest, 1), 2.5 * wall);
  return turned(vessel(foot, std::max(rim, foot), std::max(height, 3 * wall), wall));
}

DrawnSolid bottle(double size, Drawn& drawn) {
  const double h = std::min(size, kHighest);
  const double r = h * drawn.between(0.14, 0.25), neck = r * drawn.between(0.3, 0.55);
  const double shoulder = h * drawn.between(0.5, 0.7), collar = h * drawn.between(0.74, 0.85);
  return turned({{0, 0}, {r, 0}, {r, shoulder}, {neck, collar}, {neck, h}, {0, h}});
}

DrawnSolid revolution(double size, Drawn& drawn) {
  const double h = std::min(size, kHighest), widest = size * drawn.between(0.2, 0.5);
  Outline outline{{0, 0}};
  const int knots = 4 + drawn.one_of(3);
  for (int k = 0; k < knots; ++k) {
    outline.emplace_back(std::max(widest * drawn.between(0.35, 1), kThinnest), h * k / (knots - 1));
  }
  outline.emplace_back(0, h);
  return turned(outline);
}

// A polygon of boxes in (x, z), swept along y; lying, swept along z.
DrawnSolid profile(const std::vector<std::pair<Vector2d, Vector2d>>& boxes, double depth,
                   bool lies) {
  Vector2d low = Vector2d::Constant(1e9), high = -low;
  for (const auto& [a, b] : boxes) {
    low = low.cwiseMin(a);
    high = high.cwiseMax(b);
  }
  const auto solid = [=](const Vector3d& p) {
    const Vector3d q = lies ? Vector3d(p.x(), p.z(), p.y()) : p;
    double inside = 1;
    for (const auto& [a, b] : boxes) {
      const Vector2d center = (a + b) / 2, size = b - a;
      inside = std::min(inside, solids::rounded_box(q, {center.x(), 0, center.y()},
                                                    {size.x(), depth, size.y()}, 1e-3));
    }
    return inside;
  };
  DrawnSolid made;
  made.mesh = lies ? meshed(solid, {low.x(), low.y(), -depth / 2}, {high.x(), high.y(), depth / 2})
                   : meshed(solid, {low.x(), -depth / 2, low.y()}, {high.x(), depth / 2, high.y()});
  return made;
}

DrawnSolid letter(DrawnKind kind, double size, Drawn& drawn) {
  const double arm = size * drawn.between(0.5, 1);
  const double thick = std::max(size * drawn.between(0.18, 0.35), kThinnest);
  const double depth = std::max(size * drawn.between(0.2, 0.7), kThinnest);
  const bool lies = drawn.chance(0.5);
  const double height = lies ? size : std::min(size, kHighest);
  std::vector<std::pair<Vector2d, Vector2d>> boxes;
  boxes.emplace_back(Vector2d(-thick / 2, 0), Vector2d(thick / 2, height));
  if (kind == DrawnKind::kProfileL) {
    boxes.emplace_back(Vector2d(-thick / 2, 0), Vector2d(arm - thick / 2, thick));
  } else {  // stands on its bar, so that it does not fall over
    boxes.emplace_back(Vector2d(-arm / 2, 0), Vector2d(arm / 2, thick));
  }
  DrawnSolid made = profile(boxes, depth, lies);
  made.symmetric = !lies || kind == DrawnKind::kProfileT;
  return made;
}

DrawnSolid tool(double size, Drawn& drawn) {
  const double r = std::max(size * drawn.between(0.035, 0.06), kThinnest / 2);
  const double width = size * drawn.between(0.25, 0.5), deep = size * drawn.between(0.08, 0.15);
  const double high = std::max(2 * r, size * drawn.between(0.07, 0.12));
  const double end = size / 2 - deep / 2;
  return {meshed(
      [=](const Vector3d& p) {
        const double shaft =
            solids::cone_segment(p, {-size / 2 + r, 0, r}, {end, 0, r}, r, 0.8 * r);
        const double head = solids::rounded_box(p, {end, 0, high / 2}, {deep, width, high}, 1e-3);
        return std::min(shaft, head);
      },
      {-size / 2, -width / 2, 0}, {size / 2 + r, width / 2, high})};
}

DrawnSolid wedge(double size, Drawn& drawn) {
  const double width = std::max(size * drawn.between(0.3, 0.9), kThinnest);
  const double high = std::clamp(size * drawn.between(0.25, 0.8), kThinnest, kHighest);
  const Vector3d up = Vector3d(high, 0, size).normalized();  // of the slope that falls along +x
  return {meshed(
      [=](const Vector3d& p) {
        const double box = solids::rounded_box(p, {0, 0, high / 2}, {size, width, high}, 1e-3);
        return std::max(box, up.dot(p - Vector3d(-size / 2, 0, high)));
      },
      {-size / 2, -width / 2, 0}, {size / 2, width / 2, high})};
}

}  // namespace

double Drawn::between(double low, double high) {
  constexpr double kUnit = 1.0 / 9007199254740992.0;  // 2^-53
  return low + (high - low) * static_cast<double>(engine_() >> 11) * kUnit;
}

double Drawn::length(double low, double high) {
  return std::exp(between(std::log(low), std::log(high)));
}

int Drawn::one_of(int count) { return static_cast<int>(between(0, count)); }

bool Drawn::chance(double probability) { return between(0, 1) < probability; }

const char* name_of(DrawnKind kind) {
  static constexpr const char* kNames[kDrawnKinds] = {
      "box",       "cylinder", "bowl", "cup",   "bottle",  "profile_l",
      "profile_t", "ring",     "tool", "wedge", "capsule", "revolution"};
  return kNames[static_cast<int>(kind)];
}

DrawnSolid drawn_box(const Vector3d& sides) {
  return {meshed(
      [&](const Vector3d& p) {
        return solids::rounded_box(p, {0, 0, sides.z() / 2}, sides, 0.02 * sides.minCoeff());
      },
      {-sides.x() / 2, -sides.y() / 2, 0}, {sides.x() / 2, sides.y() / 2, sides.z()})};
}

DrawnSolid drawn_cylinder(double radius, double height) {
  return turned({{0, 0}, {radius, 0}, {radius, height}, {0, height}});
}

DrawnSolid drawn_solid(DrawnKind kind, double size, Drawn& drawn) {
  if (!(size > 0)) throw std::invalid_argument("drawn_solid: the size must be positive");
  const double least = std::max(kThinnest, kLeastShare * size);
  const auto side = [&] { return std::max(size * drawn.between(0.25, 1), least); };
  switch (kind) {
    case DrawnKind::kBox: {
      Vector3d sides(side(), side(), side());
      sides[drawn.one_of(3)] = size;
      sides.z() = std::min(sides.z(), kHighest);
      return drawn_box(sides);
    }
    case DrawnKind::kCylinder: {
      const double flat = drawn.length(0.35, 2.8);  // height over width
      const double width = flat > 1 ? size / flat : size;
      return drawn_cylinder(width / 2, std::clamp(width * flat, least, kHighest));
    }
    case DrawnKind::kBowl:
      return vessel_of(size, 0.22, 0.5, 0.35, drawn);
    case DrawnKind::kCup:
      return vessel_of(size, 0.8, 1.5, 0.7, drawn);
    case DrawnKind::kBottle:
      return bottle(size, drawn);
    case DrawnKind::kProfileL:
    case DrawnKind::kProfileT:
      return letter(kind, size, drawn);
    case DrawnKind::kRing: {
      const double minor = std::max(size * drawn.between(0.07, 0.14), kThinnest / 2);
      const double major = size / 2 - minor;
      DrawnSolid made;
      made.mesh = meshed(
          [=](const Vector3d& p) {
            return solids::torus(p, {0, 0, minor}, Vector3d::UnitZ(), major, minor);
          },
          {-size / 2, -size / 2, 0}, {size / 2, size / 2, 2 * minor});
      made.round = true;
      return made;
    }
    case DrawnKind::kTool:
      return tool(size, drawn);
    case DrawnKind::kWedge:
      return wedge(size, drawn);
    case DrawnKind::kCapsule: {
      const double a = size * drawn.between(0.1, 0.25), b = a * drawn.between(0.6, 1);
      const Vector3d from(-size / 2 + a, 0, a), to(size / 2 - b, 0, b);
      DrawnSolid made;
      made.mesh = meshed([=](const Vector3d& p) { return solids::cone_segment(p, from, to, a, b); },
                         {-size / 2, -a, 0}, {size / 2, a, 2 * a});
      return made;
    }
    case DrawnKind::kRevolution:
      return revolution(size, drawn);
  }
  throw std::invalid_argument("drawn_solid: no such kind");
}

std::shared_ptr<const geometry::TriangleMesh> placed(const geometry::TriangleMesh& mesh,
                                                     const Vector3d& offset, double yaw) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.linear() = Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).matrix();
  X.translation() = offset;
  return std::make_shared<geometry::TriangleMesh>(geometry::transformed(mesh, X));
}

}  // namespace prehend::eval
