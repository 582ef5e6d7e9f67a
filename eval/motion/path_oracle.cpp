#include "eval/motion/path_oracle.h"

#include <algorithm>
#include <cmath>

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>
#include <fmt/format.h>

#include "prehend/motion/link_places.h"

namespace prehend::eval {
namespace {

using geometry::RigidTransform;
using robot::CollisionShape;
using Geometry = fcl::CollisionGeometry<double>;
using Mesh = fcl::BVHModel<fcl::OBBRSS<double>>;

std::shared_ptr<Geometry> mesh_geometry(const geometry::TriangleMesh& mesh) {
  std::vector<fcl::Triangle> triangles;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    triangles.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                           static_cast<std::size_t>(t[2]));
  }
  auto model = std::make_shared<Mesh>();
  model->beginModel();
  model->addSubModel(mesh.vertices, triangles);
  model->endModel();
  return model;
}

std::shared_ptr<Geometry> geometry_of(const CollisionShape& shape) {
  switch (shape.kind) {
    case CollisionShape::Kind::kSphere:
      return std::make_shared<fcl::Sphere<double>>(shape.radius);
    case CollisionShape::Kind::kCylinder:
      return std::make_shared<fcl::Cylinder<double>>(shape.radius, shape.length);
    case CollisionShape::Kind::kMesh:
      return mesh_geometry(*shape.solid);
    case CollisionShape::Kind::kBox:
      break;
  }
  return std::make_shared<fcl::Box<double>>(shape.size);
}

std::shared_ptr<Geometry> geometry_of(const MotionObstacle& obstacle) {
  switch (obstacle.kind) {
    case MotionObstacle::Kind::kSphere:
      return std::make_shared<fcl::Sphere<double>>(obstacle.radius);
    case MotionObstacle::Kind::kCylinder:
      return std::make_shared<fcl::Cylinder<double>>(obstacle.radius, obstacle.length);
    case MotionObstacle::Kind::kBox:
      break;
  }
  return std::make_shared<fcl::Box<double>>(obstacle.size);
}

bool do_collide(const fcl::CollisionObject<double>& a, const fcl::CollisionObject<double>& b) {
  if (!a.getAABB().overlap(b.getAABB())) return false;
  const fcl::CollisionRequest<double> request;
  fcl::CollisionResult<double> result;
  return fcl::collide(&a, &b, request, result) > 0;
}

}  // namespace

struct PathOracle::Parts {
  struct Shape {
    std::size_t link;
    int joint;
    RigidTransform X_JS;
    mutable fcl::CollisionObject<double> object;
  };
  Parts(const robot::RobotModel& model, const std::string& base, const std::string& tip)
      : chain(model, base, tip) {}

  robot::KinematicChain chain;
  std::vector<std::string> names;  // of links
  std::vector<Shape> shapes;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;  // of shapes that must not touch
  std::vector<std::pair<std::string, fcl::CollisionObject<double>>> obstacles;
};

PathOracle::PathOracle(const robot::RobotModel& model, const std::string& base,
                       const std::string& tip,
                       const std::vector<std::pair<std::string, std::string>>& may_touch)
    : parts_(std::make_unique<Parts>(model, base, tip)) {
  const auto places = motion::link_places(model, parts_->chain, model.link_index(base));
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    parts_->names.push_back(model.links[i].name);
    if (!places[i]) continue;
    for (const CollisionShape& shape : model.links[i].shapes) {
      parts_->shapes.push_back({i, places[i]->joint, places[i]->X_JL * shape.X_LS,
                                fcl::CollisionObject<double>(geometry_of(shape))});
    }
  }
  const auto may = [&](const std::string& a, const std::string& b) {
    return std::ranges::any_of(may_touch, [&](const auto& pair) {
      return (pair.first == a && pair.second == b) || (pair.first == b && pair.second == a);
    });
  };
  for (std::size_t a = 0; a < parts_->shapes.size(); ++a) {
    for (std::size_t b = a + 1; b < parts_->shapes.size(); ++b) {
      const auto &one = parts_->shapes[a], &other = parts_->shapes[b];
      if (one.joint == other.joint) continue;
      if (!may(parts_->names[one.link], parts_->names[other.link]))
        parts_->pairs.emplace_back(a, b);
    }
  }
}

PathOracle::~PathOracle() = default;

void PathOracle::set_obstacles(const std::vector<MotionObstacle>& obstacles) {
  parts_->obstacles.clear();
  for (const MotionObstacle& one : obstacles) {
    fcl::CollisionObject<double> object(geometry_of(one), one.X_BO);
    object.computeAABB();
    parts_->obstacles.emplace_back(one.name, std::move(object));
  }
}

std::string PathOracle::problem(const Eigen::Ref<const Eigen::VectorXd>& q) const {
  if (const std::string limit = parts_->chain.limit_problem(q); !limit.empty()) return limit;
  std::vector<RigidTransform> X_BJ;
  parts_->chain.forward(q, X_BJ);
  for (const Parts::Shape& shape : parts_->shapes) {
    shape.object.setTransform(
        shape.joint < 0 ? shape.X_JS : X_BJ[static_cast<std::size_t>(shape.joint)] * shape.X_JS);
    shape.object.computeAABB();
    for (const auto& [name, obstacle] : parts_->obstacles) {
      // What stands with the base stands where it stands.
      if (shape.joint >= 0 && do_collide(shape.object, obstacle)) {
        return fmt::format("'{}' touches '{}'", parts_->names[shape.link], name);
      }
    }
  }
  for (const auto& [a, b] : parts_->pairs) {
    const auto &one = parts_->shapes[a], &other = parts_->shapes[b];
    if (do_collide(one.object, other.object)) {
      return fmt::format("'{}' touches '{}'", parts_->names[one.link], parts_->names[other.link]);
    }
  }
  return "";
}

std::string PathOracle::problem_along(const std::vector<robot::Positions>& waypoints,
                                      double step) const {
  for (std::size_t i = 0; i + 1 < waypoints.size(); ++i) {
    const robot::Positions way = waypoints[i + 1] - waypoints[i];
    const int steps = std::max(1, static_cast<int>(std::ceil(way.cwiseAbs().maxCoeff() / step)));
    for (int k = i == 0 ? 0 : 1; k <= steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      const std::string what = problem(robot::Positions(waypoints[i] + share * way));
      if (!what.empty()) {
        return fmt::format("{} after {:.3f} of piece {} of {}", what, share, i + 1,
                           waypoints.size() - 1);
      }
    }
  }
  return "";
}

}  // namespace prehend::eval
