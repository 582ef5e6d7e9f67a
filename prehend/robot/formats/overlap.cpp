#include "prehend/robot/formats/overlap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/collision.h>
#include <fmt/format.h>

#include "prehend/geometry/errors.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;
using Surface = fcl::BVHModel<fcl::OBBRSSd>;

constexpr std::size_t kMostTriangles = 200000;    // of a mesh that is compared as it is
constexpr std::size_t kMostHullVertices = 500;    // of a hull that is
constexpr std::size_t kMostHulledPoints = 50000;  // of a mesh whose hull is made of all of them

/// A shape, in its own frame S; shapes of one mesh share it.
struct Solid {
  TriangleMesh mesh, hull;
  std::vector<std::pair<Eigen::Vector3d, double>> faces;  // of the hull: n.p <= d is inside
  bool is_convex = false;
  std::unique_ptr<Surface> surface;  // made when it is needed
};

struct PlacedSolid {
  int link = 0;
  Solid* solid = nullptr;
  RigidTransform X_RS = RigidTransform::Identity();
  Eigen::AlignedBox3d box;  // in the robot's frame
};

/// Of many points those that are farthest along directions spread evenly over the sphere: a hull
/// from within, of a ball 0.4 % too small.
std::vector<Eigen::Vector3d> outermost(const std::vector<Eigen::Vector3d>& points) {
  constexpr int kDirections = 480;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<Eigen::Vector3d> result;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2 * i + 1.0) / kDirections, r = std::sqrt(1 - z * z);
    const Eigen::Vector3d direction(r * std::cos(golden * i), r * std::sin(golden * i), z);
    result.push_back(*std::max_element(
        points.begin(), points.end(),
        [&](const auto& a, const auto& b) { return direction.dot(a) < direction.dot(b); }));
  }
  return result;
}

/// A hull of not too many vertices.
TriangleMesh bounded_hull(const std::vector<Eigen::Vector3d>& points) {
  if (points.size() > kMostHulledPoints) return geometry::convex_hull(outermost(points));
  TriangleMesh hull = geometry::convex_hull(points);
  return hull.vertices.size() > kMostHullVertices ? geometry::convex_hull(outermost(hull.vertices))
                                                  : hull;
}

/// Vertices of one cell of a grid become one: of 128 cells along the extent they are 1/100 of it
/// off at most.
TriangleMesh thinned(const TriangleMesh& mesh, int cells) {
  const Eigen::AlignedBox3d box = geometry::bounds(mesh);
  const double cell = box.sizes().maxCoeff() / cells;
  if (!(cell > 0)) return {};
  TriangleMesh result;
  std::unordered_map<std::int64_t, int> of_cell;
  std::vector<int> index;
  index.reserve(mesh.vertices.size());
  for (const Eigen::Vector3d& p : mesh.vertices) {
    const Eigen::Vector3i at = ((p - box.min()) / cell).cast<int>();
    const std::int64_t key = (std::int64_t{at[0]} * (cells + 1) + at[1]) * (cells + 1) + at[2];
    const auto [found, is_new] = of_cell.emplace(key, static_cast<int>(result.vertices.size()));
    if (is_new) result.vertices.push_back(p);
    index.push_back(found->second);
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3i to(index[static_cast<std::size_t>(t[0])],
                             index[static_cast<std::size_t>(t[1])],
                             index[static_cast<std::size_t>(t[2])]);
    if (to[0] != to[1] && to[1] != to[2] && to[2] != to[0]) result.triangles.push_back(to);
  }
  return result;
}

std::unique_ptr<Solid> solid_of(const Shape& shape, ShapeMeshes& meshes,
                                std::vector<std::string>& remarks) {
  auto solid = std::make_unique<Solid>();
  try {
    solid->mesh = meshes.of(shape);
    if (solid->mesh.triangles.empty()) return nullptr;
    solid->hull = bounded_hull(solid->mesh.vertices);
  } catch (const geometry::InputError&) {
    return nullptr;  // check_model() says what is wrong with it
  }
  for (const Eigen::Vector3i& t : solid->hull.triangles) {
    const Eigen::Vector3d& p = solid->hull.vertices[static_cast<std::size_t>(t[0])];
    const Eigen::Vector3d normal =
        (solid->hull.vertices[static_cast<std::size_t>(t[1])] - p)
            .cross(solid->hull.vertices[static_cast<std::size_t>(t[2])] - p);
    if (!(normal.norm() > 1e-15)) continue;
    solid->faces.emplace_back(normal.normalized(), normal.normalized().dot(p));
  }
  const double volume = geometry::mass_properties(solid->hull).volume;
  constexpr double kThinned = 2e-2, kWhole = 1e-3;  // of the hull's volume
  const double rounded = solid->mesh.vertices.size() > kMostHullVertices ? kThinned : kWhole;
  solid->is_convex =
      shape.kind != Shape::Kind::kMesh ||
      std::abs(geometry::mass_properties(solid->mesh).volume - volume) < rounded * volume;
  if (solid->mesh.triangles.size() > kMostTriangles) {
    const std::size_t before = solid->mesh.triangles.size();
    for (int cells = 128; solid->mesh.triangles.size() > kMostTriangles && cells > 1; cells /= 2) {
      solid->mesh = thinned(solid->mesh, cells);
    }
    if (solid->mesh.triangles.empty()) return nullptr;
    remarks.push_back(fmt::format("'{}', of {} triangles, was thinned to {}", shape.mesh, before,
                                  solid->mesh.triangles.size()));
  }
  return solid;
}

/// The least way that parts the hulls, along normals of their faces; 0 or less: they are apart.
double depth_of(const PlacedSolid& a, const PlacedSolid& b) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [one, other] : {std::pair(&a, &b), std::pair(&b, &a)}) {
    const RigidTransform X = one->X_RS.inverse() * other->X_RS;
    std::vector<Eigen::Vector3d> points;
    points.reserve(other->solid->hull.vertices.size());
    for (const Eigen::Vector3d& p : other->solid->hull.vertices) points.push_back(X * p);
    for (const auto& [normal, distance] : one->solid->faces) {
      double lowest = std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3d& p : points) lowest = std::min(lowest, normal.dot(p));
      least = std::min(least, distance - lowest);
      if (least <= 0) return least;
    }
  }
  return least;
}

/// How many numbers depth_of() looks at.
std::size_t cost_of(const PlacedSolid& a, const PlacedSolid& b) {
  return a.solid->faces.size() * b.solid->hull.vertices.size() +
         b.solid->faces.size() * a.solid->hull.vertices.size();
}

bool has_corner_in(const PlacedSolid& a, const PlacedSolid& b) {
  const RigidTransform X = b.X_RS.inverse() * a.X_RS;
  return std::any_of(
      a.solid->hull.vertices.begin(), a.solid->hull.vertices.end(), [&](const auto& corner) {
        const Eigen::Vector3d p = X * corner;
        return std::all_of(b.solid->faces.begin(), b.solid->faces.end(),
                           [&](const auto& face) { return face.first.dot(p) < face.second; });
      });
}

const Surface& surface_of(Solid& solid) {
  if (!solid.surface) {
    solid.surface = std::make_unique<Surface>();
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(solid.mesh.triangles.size());
    for (const Eigen::Vector3i& t : solid.mesh.triangles) {
      triangles.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                             static_cast<std::size_t>(t[2]));
    }
    solid.surface->beginModel();
    solid.surface->addSubModel(solid.mesh.vertices, triangles);
    solid.surface->endModel();
  }
  return *solid.surface;
}

/// Whether surfaces cross, or one solid is in another that is convex.
bool do_overlap(const PlacedSolid& a, const PlacedSolid& b) {
  const bool is_in =
      (b.solid->is_convex && has_corner_in(a, b)) || (a.solid->is_convex && has_corner_in(b, a));
  if (is_in) return true;
  const fcl::CollisionRequest<double> request(1, false);
  fcl::CollisionResult<double> result;
  return fcl::collide(&surface_of(*a.solid), a.X_RS, &surface_of(*b.solid), b.X_RS, request,
                      result) > 0;
}

/// Pairs of links that may touch: held together by joints, loops, or said to be.
class AllowedPairs {
 public:
  explicit AllowedPairs(const RobotDescription& robot) {
    for (const LinkDescription& link : robot.links) body_[link.name] = link.name;
    // What fixed joints hold together is one body.
    std::map<std::string, std::string> fixed_to;
    for (const JointDescription& joint : robot.joints) {
      if (joint.kind == JointDescription::Kind::kFixed) fixed_to[joint.child] = joint.parent;
    }
    for (const std::string& name : tree_order(robot)) {
      const auto found = fixed_to.find(name);
      if (found != fixed_to.end()) body_[name] = body_.at(found->second);
    }
    for (const JointDescription& joint : robot.joints) add(body(joint.parent), body(joint.child));
    for (const Loop& loop : robot.loops) add(body(loop.first), body(loop.second));
    for (const auto& [first, second] : robot.disabled_collisions) {
      said_.insert(std::minmax(first, second));
    }
  }
  bool contains(const std::string& first, const std::string& second) const {
    return body(first) == body(second) ||
           bodies_.count(std::minmax(body(first), body(second))) != 0 ||
           said_.count(std::minmax(first, second)) != 0;
  }

 private:
  std::string body(const std::string& link) const {
    const auto found = body_.find(link);
    return found == body_.end() ? link : found->second;
  }
  void add(const std::string& first, const std::string& second) {
    bodies_.insert(std::minmax(first, second));
  }
  std::map<std::string, std::string> body_;
  std::set<std::pair<std::string, std::string>> bodies_, said_;
};

}  // namespace

std::vector<LinkOverlap> overlaps_at_rest(const RobotDescription& robot, ShapeMeshes& meshes,
                                          double least, std::vector<std::string>* remarks) {
  std::vector<std::string> unsaid;
  if (!remarks) remarks = &unsaid;
  std::map<std::string, double> rest;
  for (const JointDescription& joint : robot.joints) {
    rest[joint.name] = std::max(joint.lower.value_or(0), std::min(0.0, joint.upper.value_or(0)));
  }
  const auto poses = link_poses(robot, rest);
  const AllowedPairs allowed(robot);
  // Made once for shapes that are alike.
  using Key = std::tuple<Shape::Kind, std::string, const void*, std::array<double, 8>>;
  std::map<Key, std::unique_ptr<Solid>> solids;
  std::vector<PlacedSolid> placed;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    const LinkDescription& link = robot.links[i];
    for (const Shape& shape : link.collisions) {
      const std::array<double, 8> sizes{shape.size.x(),  shape.size.y(),  shape.size.z(),
                                        shape.scale.x(), shape.scale.y(), shape.scale.z(),
                                        shape.radius,    shape.length};
      const auto [at, is_new] =
          solids.try_emplace({shape.kind, shape.mesh, shape.surface.get(), sizes});
      if (is_new) at->second = solid_of(shape, meshes, *remarks);
      Solid* const solid = at->second.get();
      if (!solid) continue;
      PlacedSolid one{static_cast<int>(i), solid, poses.at(link.name) * shape.X_LS, {}};
      for (const Eigen::Vector3d& p : solid->hull.vertices) one.box.extend(one.X_RS * p);
      const bool is_somewhere = one.box.min().allFinite() && one.box.max().allFinite();
      if (is_somewhere) placed.push_back(one);
    }
  }
  std::sort(placed.begin(), placed.end(), [](const PlacedSolid& a, const PlacedSolid& b) {
    return a.box.min().x() < b.box.min().x();
  });
  const auto name = [&](const PlacedSolid& one) -> const std::string& {
    return robot.links[static_cast<std::size_t>(one.link)].name;
  };
  // A hand costs some millions; a file of shapes that are all at one place would never end.
  constexpr std::size_t kMostWork = 300000000, kLookedUp = 500;
  std::size_t work = 0;
  std::map<std::pair<std::string, std::string>, double> deepest;
  for (std::size_t i = 0; i < placed.size() && work < kMostWork; ++i) {
    for (std::size_t j = i + 1;
         j < placed.size() && placed[j].box.min().x() <= placed[i].box.max().x(); ++j) {
      const PlacedSolid &a = placed[i], &b = placed[j];
      if (++work >= kMostWork) break;
      if (a.link == b.link || !a.box.intersects(b.box)) continue;
      work += kLookedUp;
      if (allowed.contains(name(a), name(b))) continue;
      work += cost_of(a, b);
      const double depth = depth_of(a, b);
      const std::pair<std::string, std::string> key = std::minmax(name(a), name(b));
      const auto known = deepest.find(key);
      if (depth <= least || (known != deepest.end() && known->second >= depth)) continue;
      work += kLookedUp * kLookedUp;
      if (do_overlap(a, b)) deepest[key] = depth;
    }
  }
  if (work >= kMostWork) {
    remarks->push_back(fmt::format("{} shapes have more pairs near one another than are looked at",
                                   placed.size()));
  }
  std::vector<LinkOverlap> result;
  result.reserve(deepest.size());
  for (const auto& [links, depth] : deepest) result.push_back({links.first, links.second, depth});
  return result;
}

}  // namespace prehend::robot::formats
