#include "prehend/motion/shapes_in_world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "prehend/motion/collision_world.h"
#include "prehend/motion/kept_apart.h"
#include "prehend/motion/robot_spheres.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

/// A ball that holds a body.
struct BodyBound {
  Vector3d center = Vector3d::Zero();
  double radius = 0;
};

BodyBound bound_of(const ConvexBody& body) {
  BodyBound bound;
  switch (body.kind) {
    case ConvexBody::Kind::kBox:
      bound.radius = body.size.norm() / 2;
      break;
    case ConvexBody::Kind::kSphere:
      bound.radius = body.radius;
      break;
    case ConvexBody::Kind::kCylinder:
      bound.radius = std::hypot(body.radius, body.length / 2);
      break;
    case ConvexBody::Kind::kPoints: {
      Eigen::AlignedBox3d box;
      for (const Vector3d& p : *body.points) box.extend(p);
      bound.center = box.center();
      for (const Vector3d& p : *body.points) {
        bound.radius = std::max(bound.radius, (p - bound.center).norm());
      }
      break;
    }
  }
  return bound;
}

RigidTransform pose_of(const CheckedRobot::Shape& shape, const std::vector<RigidTransform>& X_BJ) {
  return shape.joint < 0 ? shape.X_JS : X_BJ[static_cast<std::size_t>(shape.joint)] * shape.X_JS;
}

bool are_far(const Vector3d& a, double radius_a, const Vector3d& b, double radius_b, double gap) {
  const double far = radius_a + radius_b + gap;
  return (a - b).squaredNorm() > far * far;
}

bool do_touch(const CheckedRobot& robot, int a, int b, const std::vector<RigidTransform>& X_BS) {
  const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
  const CheckedRobot::Shape &one = robot.shapes()[i], &other = robot.shapes()[j];
  return !are_far(X_BS[i] * one.center_S, one.radius, X_BS[j] * other.center_S, other.radius, 0) &&
         robot.checker().are_nearer(*one.checked, X_BS[i], *other.checked, X_BS[j], 0);
}

}  // namespace

CheckedRobot::CheckedRobot(std::shared_ptr<const CollisionChecker> checker,
                           const std::vector<RobotShape>& shapes,
                           const robot::KinematicChain& chain)
    : checker_(std::move(checker)), joints_(chain.size()) {
  if (!checker_) throw std::invalid_argument("CheckedRobot: there is no checker");
  std::vector<RigidTransform> X_BJ, X_BS;
  chain.forward(chain.middle(), X_BJ);
  for (const RobotShape& shape : shapes) {
    const BodyBound bound = bound_of(shape.body);
    shapes_.push_back({shape.joint, shape.X_JS, shape.body, checker_->body(shape.body),
                       bound.center, bound.radius});
    X_BS.push_back(pose_of(shapes_.back(), X_BJ));
  }
  const auto ball_round = [](const Shape& shape) {
    return RobotSphere{shape.joint, shape.X_JS * shape.center_S, shape.radius};
  };
  const int count = static_cast<int>(shapes_.size());
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      const Shape &one = shapes_[static_cast<std::size_t>(a)],
                  &other = shapes_[static_cast<std::size_t>(b)];
      // Neighbours are made to touch.
      if (std::abs(one.joint - other.joint) < 2 || do_touch(*this, a, b, X_BS) ||
          are_kept_apart(chain, ball_round(one), ball_round(other))) {
        continue;
      }
      self_pairs_.emplace_back(a, b);
    }
  }
}

double CheckedRobot::reach(const Shape& shape) {
  return (shape.X_JS * shape.center_S).norm() + shape.radius;
}

ShapesInWorld::ShapesInWorld(std::shared_ptr<const CheckedRobot> robot, const CollisionWorld& world,
                             double margin, const ShapesInWorld* before)
    : robot_(std::move(robot)) {
  using Kind = CollisionWorld::Obstacle::Kind;
  for (const CollisionWorld::Obstacle& from : world.obstacles()) {
    Obstacle obstacle;
    obstacle.center_B = from.center;
    obstacle.radius = from.radius;
    obstacle.margin = {from.margin_for(Part::kArm, margin), from.margin_for(Part::kHand, margin)};
    if (from.kind == Kind::kPlane) {
      obstacle.is_plane = true;
      obstacle.plane = from.faces.front();
      obstacles_.push_back(std::move(obstacle));
      continue;
    }
    ConvexBody body;
    if (from.kind == Kind::kBox) {
      obstacle.X_BO = from.X_OB.inverse();
      body.size = 2 * from.half;
    } else if (from.kind == Kind::kSphere) {
      obstacle.X_BO.translation() = from.center;
      body.kind = ConvexBody::Kind::kSphere;
      body.radius = from.radius;
    } else {
      body.kind = ConvexBody::Kind::kPoints;
      body.points = obstacle.points = from.points;
    }
    if (before && obstacle.points) {
      for (const Obstacle& known : before->obstacles_) {
        if (known.points == obstacle.points) obstacle.checked = known.checked;
      }
    }
    if (!obstacle.checked) obstacle.checked = robot_->checker().body(body);
    obstacles_.push_back(std::move(obstacle));
  }
}

ShapesInWorld::Touch ShapesInWorld::first_touch(const std::vector<RigidTransform>& X_BJ,
                                                const double* swell) const {
  thread_local std::vector<RigidTransform> X_BS;
  X_BS.clear();
  const std::vector<CheckedRobot::Shape>& shapes = robot_->shapes();
  for (const CheckedRobot::Shape& shape : shapes) X_BS.push_back(pose_of(shape, X_BJ));
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const CheckedRobot::Shape& shape = shapes[i];
    // What stands with the base never moves.
    if (shape.joint < 0) continue;
    const std::size_t part = shape.joint == robot_->joints() - 1 ? 1 : 0;
    const double more = swell ? swell[shape.joint] : 0;
    const Vector3d center_B = X_BS[i] * shape.center_S;
    for (std::size_t k = 0; k < obstacles_.size(); ++k) {
      const Obstacle& obstacle = obstacles_[k];
      const double margin = obstacle.margin[part];
      if (margin == -std::numeric_limits<double>::infinity()) continue;
      bool touches = false;
      if (obstacle.is_plane) {
        const Vector3d down_S = X_BS[i].linear().transpose() * -obstacle.plane.normal;
        const double height = obstacle.plane.signed_distance(X_BS[i].translation());
        touches = height - support(shape.body, down_S) < margin + more;
      } else {
        const double gap = std::max(0.0, margin) + more;
        touches = !are_far(center_B, shape.radius, obstacle.center_B, obstacle.radius, gap) &&
                  robot_->checker().are_nearer(*shape.checked, X_BS[i], *obstacle.checked,
                                               obstacle.X_BO, gap);
      }
      if (touches) return {true, shape.joint, static_cast<int>(k), -1};
    }
  }
  for (const auto& [a, b] : robot_->self_pairs()) {
    if (!do_touch(*robot_, a, b, X_BS)) continue;
    return {true, shapes[static_cast<std::size_t>(a)].joint, -1,
            shapes[static_cast<std::size_t>(b)].joint};
  }
  return {};
}

}  // namespace prehend::motion
