#pragma once

#include <memory>
#include <vector>

#include <fcl/fcl.h>

#include "prehend/motion/robot_in_world.h"

namespace prehend::motion {

/// The robot's own shapes and obstacles in FCL, for comparison.
struct FclOracle {
  using Object = fcl::CollisionObject<double>;
  struct Part {
    int joint;
    geometry::RigidTransform X_JS;
    std::shared_ptr<fcl::CollisionGeometry<double>> shape;
  };
  std::vector<Part> parts;
  std::vector<Object> obstacles;

  static std::shared_ptr<fcl::CollisionGeometry<double>> make(const robot::CollisionShape& shape) {
    using Kind = robot::CollisionShape::Kind;
    if (shape.kind == Kind::kSphere) return std::make_shared<fcl::Sphere<double>>(shape.radius);
    if (shape.kind == Kind::kCylinder) {
      return std::make_shared<fcl::Cylinder<double>>(shape.radius, shape.length);
    }
    return std::make_shared<fcl::Box<double>>(shape.size);
  }

  /// Every shape of the links that the chain's joints move, in order.
  FclOracle(const robot::RobotModel& model, const robot::KinematicChain& chain) {
    for (std::size_t i = 0; i < chain.joints().size(); ++i) {
      const auto& joint =
          model.joints[static_cast<std::size_t>(model.joint_index(chain.joints()[i].name))];
      for (const auto& shape : model.links[static_cast<std::size_t>(joint.child)].shapes) {
        parts.push_back({static_cast<int>(i), shape.X_LS, make(shape)});
      }
    }
  }

  void add_box(const geometry::RigidTransform& X_BO, const Eigen::Vector3d& size) {
    obstacles.emplace_back(std::make_shared<fcl::Box<double>>(size), X_BO);
  }
  void add_sphere(const Eigen::Vector3d& center, double radius) {
    geometry::RigidTransform X = geometry::RigidTransform::Identity();
    X.translation() = center;
    obstacles.emplace_back(std::make_shared<fcl::Sphere<double>>(radius), X);
  }

  bool collides(const robot::KinematicChain& chain, const robot::Positions& q) const {
    std::vector<geometry::RigidTransform> poses;
    chain.forward(q, poses);
    for (const Part& part : parts) {
      const Object object(part.shape, poses[static_cast<std::size_t>(part.joint)] * part.X_JS);
      for (const Object& obstacle : obstacles) {
        fcl::CollisionResult<double> result;
        fcl::collide(&object, &obstacle, fcl::CollisionRequest<double>(), result);
        if (result.isCollision()) return true;
      }
    }
    return false;
  }
};

}  // namespace prehend::motion
