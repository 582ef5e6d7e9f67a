#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/motion/batch_scene.h"
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
    std::vector<geometry::Plane> faces;  // outward; plane and convex
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
  /// counts as touching when no face separates them: early, by 0.42 of its radius beside a right
  /// edge, 0.74 beside a box's corner and more beside sharper ones, but never late. Flat
  /// pieces get a thickness, see convex_faces(). @throws geometry::InputError for a mesh without
  /// finite vertices.
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

/// A robot in a world: which positions are free.
class RobotInWorld {
 public:
  /// `margin` [m] is kept from obstacles, not between the robot's own parts.
  RobotInWorld(robot::KinematicChain chain, RobotSpheres spheres, CollisionWorld world,
               double margin = 0.005);

  const robot::KinematicChain& chain() const { return chain_; }
  const RobotSpheres& spheres() const { return spheres_; }
  const CollisionWorld& world() const { return world_; }
  /// Lets `change` change the world.
  template <class Change>
  void change_world(Change change) {
    change(world_);
    compile();
  }
  double margin() const { return margin_; }

  /// Balls held by the tip, in its frame (a grasped object); they are not tested against the last
  /// two joints' own balls.
  void attach(const std::vector<RobotSphere>& balls_T);
  /// The same and change_world() in one: half as costly. The change may ask for held_clearance().
  template <class Change>
  void attach(const std::vector<RobotSphere>& balls_T, Change change) {
    hold(balls_T);
    change(world_);
    compile();
  }
  void detach();
  /// Distance of what is held from all obstacles of that name at `q` [m], as
  /// CollisionWorld::clearance(); infinite when nothing is held.
  double held_clearance(const std::string& name, const Eigen::Ref<const Eigen::VectorXd>& q) const;

  /// Within limits, clear of obstacles and of itself.
  bool is_free(const Eigen::Ref<const Eigen::VectorXd>& q) const;
  /// "link of joint 'e2' touches 'table'"; empty when free.
  std::string problem(const Eigen::Ref<const Eigen::VectorXd>& q) const;
  /// Which of up to kBatch positions are not: bit i for q[i]. As is_free() in single precision:
  /// what is within 2 um of touching may count as touching, and nothing that touches as free.
  std::uint32_t not_free(const robot::Positions* q, int count) const;
  /// Whether the straight line in joint space is free at steps of at most `step` [rad or m] of any
  /// joint, both ends included, by kBatch positions at once as not_free(). Each batch is spread
  /// over the whole line, which finds collisions early.
  bool is_free_between(const Eigen::Ref<const Eigen::VectorXd>& from,
                       const Eigen::Ref<const Eigen::VectorXd>& to, double step) const;
  /// Whether the straight line in joint space is free, and no ball reaches an obstacle that is
  /// given the whole margin (at least 1 mm) between tested positions either. By bisection: a piece
  /// is free when, in its middle, balls that are larger by what they can move on half of the piece
  /// are (F. Schwarzer, M. Saha, J.-C. Latombe, "Exact collision checking of robot paths", WAFR
  /// 2002). The robot's own parts are tested at the middles only, at steps of at most 0.05 rad or
  /// m.
  bool is_swept_free(const Eigen::Ref<const Eigen::VectorXd>& from,
                     const Eigen::Ref<const Eigen::VectorXd>& to) const;

 private:
  /// A ball that touches an obstacle, or another ball.
  struct Touch {
    int ball = -1;  // none
    int other = -1;
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
  };
  Touch first_touch(const Eigen::Ref<const Eigen::VectorXd>& q) const;
  /// Positions at `shares` of the way, as touching_lanes() takes them; the last one fills up.
  void fill_lanes(const Eigen::Ref<const Eigen::VectorXd>& from,
                  const Eigen::Ref<const Eigen::VectorXd>& to, const double* shares,
                  std::size_t count, float* q) const;
  void hold(const std::vector<RobotSphere>& balls_T);
  void let_go();
  void compile();
  void find_levers();

  robot::KinematicChain chain_;
  RobotSpheres spheres_;
  CollisionWorld world_;
  double margin_;
  std::size_t own_;  // spheres that are not attached
  std::size_t own_pairs_;
  BatchScene batch_;
  /// m: the way of a ball of joint k is at most (k, j) for each radian (for each m: 1) of joint j.
  Eigen::MatrixXd levers_;
};

}  // namespace prehend::motion
