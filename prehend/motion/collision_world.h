#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/motion/robot_spheres.h"

namespace prehend::motion {

/// What a robot must not touch. Everything in the robot's base frame B, metres.
class CollisionWorld {
 public:
  /// A half-space: collides with what is below the plane.
  void add_plane(const std::string& name, const geometry::Plane& plane_B);
  /// @throws std::invalid_argument for sides that are not positive.
  void add_box(const std::string& name, const geometry::RigidTransform& X_BO,
               const Eigen::Vector3d& size);
  /// @throws std::invalid_argument for a radius that is not positive.
  void add_sphere(const std::string& name, const Eigen::Vector3d& center_B, double radius);
  /// The convex hull of the mesh's vertices, as the predicted pieces of an object are. A ball
  /// counts as touching when no face separates them: early, by 0.42 of its radius beside a right
  /// edge, 0.74 beside a box's corner and more beside sharper ones, but never late. @throws
  /// geometry::InputError for a mesh without volume.
  void add_convex(const std::string& name, const geometry::TriangleMesh& mesh_B);
  /// False when there is nothing of that name; all of that name goes.
  bool remove(const std::string& name);

  /// Distance of a ball's surface to the nearest obstacle [m], negative when they overlap, and
  /// never more than the true one; infinite without obstacles. `nearest` gets the obstacle's name.
  double clearance(const Eigen::Vector3d& center_B, double radius,
                   std::string* nearest = nullptr) const;
  /// Whether the ball comes nearer to an obstacle than `margin` [m].
  bool touches(const Eigen::Vector3d& center_B, double radius, double margin) const;

 private:
  struct Obstacle {
    enum class Kind { kPlane, kBox, kSphere, kConvex };
    std::string name;
    Kind kind = Kind::kPlane;
    geometry::RigidTransform X_OB = geometry::RigidTransform::Identity();  // box
    Eigen::Vector3d half = Eigen::Vector3d::Zero();                        // box
    Eigen::Vector3d center = Eigen::Vector3d::Zero();                      // ball round all of it
    double radius = 0;
    std::vector<geometry::Plane> faces;  // outward; plane and convex
  };
  static double distance(const Obstacle& obstacle, const Eigen::Vector3d& p_B);
  std::vector<Obstacle> obstacles_;
};

/// A robot in a world: which positions are free.
class RobotInWorld {
 public:
  /// `margin` [m] is kept from obstacles, not between the robot's own parts.
  RobotInWorld(robot::KinematicChain chain, RobotSpheres spheres, CollisionWorld world,
               double margin = 0.005);

  const robot::KinematicChain& chain() const { return chain_; }
  const RobotSpheres& spheres() const { return spheres_; }
  const CollisionWorld& world() const { return world_; }
  CollisionWorld& world() { return world_; }

  /// Balls held by the tip, in its frame (a grasped object); they are not tested against the last
  /// two joints' own balls.
  void attach(const std::vector<RobotSphere>& balls_T);
  void detach();

  /// Within limits, clear of obstacles and of itself.
  bool is_free(const Eigen::Ref<const Eigen::VectorXd>& q) const;
  /// "link of joint 'e2' touches 'table'"; empty when free.
  std::string problem(const Eigen::Ref<const Eigen::VectorXd>& q) const;
  /// Whether the straight line in joint space is free at steps of at most `step` [rad or m] of any
  /// joint, both ends included. Tested from coarse to fine, which finds collisions early.
  bool is_free_between(const Eigen::Ref<const Eigen::VectorXd>& from,
                       const Eigen::Ref<const Eigen::VectorXd>& to, double step) const;

 private:
  /// A ball that touches an obstacle, or another ball.
  struct Touch {
    int ball = -1;  // none
    int other = -1;
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
  };
  Touch first_touch(const Eigen::Ref<const Eigen::VectorXd>& q) const;

  robot::KinematicChain chain_;
  RobotSpheres spheres_;
  CollisionWorld world_;
  double margin_;
  std::size_t own_;  // spheres that are not attached
  std::size_t own_pairs_;
};

}  // namespace prehend::motion
