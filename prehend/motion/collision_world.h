#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/motion/robot_spheres.h"

namespace prehend::motion {

/// Who must not touch: the arm, what moves with its last joint, what that holds.
enum class Part { kArm, kHand, kHeld };

/// What a robot must not touch. Everything in the robot's base frame B, metres.
class CollisionWorld {
 public:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  /// X_OB, half and center of a box; center and radius: a ball round all of it.
  struct Obstacle {
    enum class Kind { kPlane, kBox, kSphere, kConvex };
    std::string name;
    Kind kind = Kind::kPlane;
    geometry::RigidTransform X_OB = geometry::RigidTransform::Identity();  // box
    Eigen::Vector3d half = Eigen::Vector3d::Zero();                        // box
    Eigen::Vector3d center = Eigen::Vector3d::Zero();                      // ball round all of it
    double radius = 0;
    Eigen::AlignedBox3d bounds;          // round all of it, along the base's axes; not of a plane
    std::vector<geometry::Plane> faces;  // outward; plane and convex
    std::shared_ptr<const std::vector<Eigen::Vector3d>> points;  // whose hull it is; convex
    /// For each Part; infinity: the robot's.
    std::array<double, 3> margin{kInfinity, kInfinity, kInfinity};

    double margin_for(Part part, double otherwise) const {
      const double own = margin[static_cast<std::size_t>(part)];
      return own < kInfinity ? own : otherwise;
    }
  };

  /// A half-space: collides with what is below the plane.
  void add_plane(const std::string& name, const geometry::Plane& plane_B);
  /// @throws std::invalid_argument for sides that are not positive.
  void add_box(const std::string& name, const geometry::RigidTransform& X_BO,
               const Eigen::Vector3d& size);
  /// @throws std::invalid_argument for a radius that is not positive.
  void add_sphere(const std::string& name, const Eigen::Vector3d& center_B, double radius);
  /// The convex hull of the mesh's vertices, as the predicted pieces of an object are. A ball
  /// counts as touching when neither a face nor a side of the box round the piece, along the base's
  /// axes, separates them: early, by 0.42 of its radius beside a right edge, 0.74 beside a box's
  /// corner and more beside sharper ones, but never late. Flat pieces get a thickness, see
  /// convex_faces(). @throws geometry::InputError for a mesh without finite vertices.
  void add_convex(const std::string& name, const geometry::TriangleMesh& mesh_B);
  /// False when there is nothing of that name; all of that name goes.
  bool remove(const std::string& name);
  /// What `part` keeps from all of that name, instead of the robot's margin [m]; negative: so deep
  /// it may be in it; -infinity: it may touch. False when there is nothing of that name.
  bool set_margin(const std::string& name, Part part, double margin);

  /// Distance of a ball's surface to the nearest obstacle [m], negative when they overlap, and
  /// never more than the true one; infinite without obstacles. `nearest` gets the obstacle's name.
  double clearance(const Eigen::Vector3d& center_B, double radius,
                   std::string* nearest = nullptr) const;
  /// Whether the ball, of `part`, comes nearer to an obstacle than `margin` [m] or what has been
  /// set for it. `touched` gets the name of the one it is deepest in.
  bool touches(const Eigen::Vector3d& center_B, double radius, double margin,
               Part part = Part::kArm, std::string* touched = nullptr) const;
  const std::vector<Obstacle>& obstacles() const { return obstacles_; }
  /// Names without repetition, in the order in which they came.
  std::vector<std::string> names() const;
  /// As clearance(), of the obstacles of one name.
  double clearance_from(const std::string& name, const Eigen::Vector3d& center_B,
                        double radius) const;

 private:
  /// Any value that is not less than `enough` stands for all of them.
  static double distance(const Obstacle& obstacle, const Eigen::Vector3d& p_B,
                         double enough = kInfinity);
  std::vector<Obstacle> obstacles_;
};

/// The part that a ball is of. @param joints of the chain.
Part part_of_ball(const RobotSphere& ball, bool is_held, int joints);

}  // namespace prehend::motion
