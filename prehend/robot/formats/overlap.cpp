#include "prehend/robot/formats/overlap.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/collision.h>

#include "prehend/geometry/errors.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;
using Surface = fcl::BVHModel<fcl::OBBRSSd>;

/// A shape in the robot's frame.
struct PlacedSolid {
  std::string link;
  TriangleMesh mesh, hull;
  Eigen::AlignedBox3d box;
  std::vector<std::pair<Eigen::Vector3d, double>> faces;  // of the hull: n.p <= d is inside
  bool is_convex = false;
  std::shared_ptr<Surface> surface;  // made when it is needed
};

std::optional<PlacedSolid> placed_solid(const std::string& link, const Shape& shape,
                                        const RigidTransform& X, ShapeMeshes& meshes) {
  PlacedSolid solid;
  solid.link = link;
  try {
    solid.mesh = geometry::transformed(meshes.of(shape), X * shape.X_LS);
    if (solid.mesh.triangles.empty()) return std::nullopt;
    solid.hull = geometry::convex_hull(solid.mesh.vertices);
  } catch (const geometry::InputError&) {
    return std::nullopt;  // check_model() says what is wrong with it
  }
  for (const Eigen::Vector3i& t : solid.hull.triangles) {
    const Eigen::Vector3d& p = solid.hull.vertices[static_cast<std::size_t>(t[0])];
    const Eigen::Vector3d normal =
        (solid.hull.vertices[static_cast<std::size_t>(t[1])] - p)
            .cross(solid.hull.vertices[static_cast<std::size_t>(t[2])] - p);
    if (!(normal.norm() > 1e-15)) continue;
    solid.faces.emplace_back(normal.normalized(), normal.normalized().dot(p));
  }
  solid.box = geometry::bounds(solid.mesh);
  const double volume = geometry::mass_properties(solid.hull).volume;
  solid.is_convex = shape.kind != Shape::Kind::kMesh ||
                    std::abs(geometry::mass_properties(solid.mesh).volume - volume) < 1e-3 * volume;
  return solid;
}

/// The least way that parts the hulls, along normals of their faces; 0 or less: they are apart.
double depth_of(const PlacedSolid& a, const PlacedSolid& b) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [one, other] : {std::pair(&a, &b), std::pair(&b, &a)}) {
    for (const auto& [normal, distance] : one->faces) {
      double lowest = std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3d& p : other->hull.vertices) {
        lowest = std::min(lowest, normal.dot(p));
      }
      least = std::min(least, distance - lowest);
      if (least <= 0) return least;
    }
  }
  return least;
}

bool has_corner_in(const PlacedSolid& a, const PlacedSolid& b) {
  return std::any_of(a.hull.vertices.begin(), a.hull.vertices.end(), [&](const auto& p) {
    return std::all_of(b.faces.begin(), b.faces.end(),
                       [&](const auto& face) { return face.first.dot(p) < face.second; });
  });
}

const Surface& surface_of(PlacedSolid& solid) {
  if (!solid.surface) {
    solid.surface = std::make_shared<Surface>();
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
bool do_overlap(PlacedSolid& a, PlacedSolid& b) {
  if ((b.is_convex && has_corner_in(a, b)) || (a.is_convex && has_corner_in(b, a))) return true;
  const fcl::CollisionRequest<double> request(1, false);
  fcl::CollisionResult<double> result;
  const RigidTransform here = RigidTransform::Identity();
  return fcl::collide(&surface_of(a), here, &surface_of(b), here, request, result) > 0;
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
                                          double least) {
  std::map<std::string, double> rest;
  for (const JointDescription& joint : robot.joints) {
    rest[joint.name] = std::max(joint.lower.value_or(0), std::min(0.0, joint.upper.value_or(0)));
  }
  const auto poses = link_poses(robot, rest);
  const AllowedPairs allowed(robot);
  std::vector<PlacedSolid> solids;
  for (const LinkDescription& link : robot.links) {
    for (const Shape& shape : link.collisions) {
      if (auto solid = placed_solid(link.name, shape, poses.at(link.name), meshes)) {
        solids.push_back(std::move(*solid));
      }
    }
  }
  std::sort(solids.begin(), solids.end(), [](const PlacedSolid& a, const PlacedSolid& b) {
    return a.box.min().x() < b.box.min().x();
  });
  std::map<std::pair<std::string, std::string>, double> deepest;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    for (std::size_t j = i + 1;
         j < solids.size() && solids[j].box.min().x() <= solids[i].box.max().x(); ++j) {
      PlacedSolid &a = solids[i], &b = solids[j];
      if (a.link == b.link || !a.box.intersects(b.box) || allowed.contains(a.link, b.link)) {
        continue;
      }
      const double depth = depth_of(a, b);
      const std::pair<std::string, std::string> key = std::minmax(a.link, b.link);
      const auto known = deepest.find(key);
      if (depth <= least || (known != deepest.end() && known->second >= depth)) continue;
      if (do_overlap(a, b)) deepest[key] = depth;
    }
  }
  std::vector<LinkOverlap> result;
  result.reserve(deepest.size());
  for (const auto& [links, depth] : deepest) result.push_back({links.first, links.second, depth});
  return result;
}

}  // namespace prehend::robot::formats
