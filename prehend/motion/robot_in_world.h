#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "prehend/motion/batch_kernel.h"
#include "prehend/motion/batch_scene.h"
#include "prehend/motion/collision_world.h"
#include "prehend/motion/free_space.h"
#include "prehend/motion/robot_spheres.h"
#include "prehend/motion/shapes_in_world.h"

namespace prehend::motion {

/// A robot in a world: which positions are free. By its balls (`balls`), which hold its shapes, or,
/// after use_checker(), by the shapes themselves and another checker: slower, and freer by what the
/// balls are larger. What is held is its balls with any checker.
class RobotInWorld final : public FreeSpace {
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
  int size() const override { return chain_.size(); }
  double lower(int joint) const override {
    return chain_.joints()[static_cast<std::size_t>(joint)].lower;
  }
  double upper(int joint) const override {
    return chain_.joints()[static_cast<std::size_t>(joint)].upper;
  }

  /// From now on the links' shapes are tested, by `checker`, instead of their balls; null: the
  /// balls again. Negative margins of links count as 0 then, but for planes and -infinity.
  /// @param shapes of make_robot_shapes() for the chain's base and tip.
  /// @throws std::invalid_argument for a shape of a joint that the chain does not have.
  void use_checker(std::shared_ptr<const CollisionChecker> checker,
                   const std::vector<RobotShape>& shapes);

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
  bool is_free(const Eigen::Ref<const Eigen::VectorXd>& q) const override;
  /// "link of joint 'e2' touches 'table'"; empty when free.
  std::string problem(const Eigen::Ref<const Eigen::VectorXd>& q) const override;
  /// Which of up to kBatch positions are not: bit i for q[i]. As is_free() in single precision:
  /// what is within 2 um of touching may count as touching, and nothing that touches as free. With
  /// another checker one after the other, in double precision.
  std::uint32_t not_free(const robot::Positions* q, int count) const override;
  /// Whether the straight line in joint space is free at steps of at most `step` [rad or m] of any
  /// joint, both ends included, by kBatch positions at once as not_free(). Each batch is spread
  /// over the whole line, which finds collisions early.
  bool is_free_between(const Eigen::Ref<const Eigen::VectorXd>& from,
                       const Eigen::Ref<const Eigen::VectorXd>& to, double step) const override;
  /// Whether the straight line in joint space is free, and between tested positions no ball reaches
  /// an obstacle that is given the whole margin (at least kBallSpare), or another of the robot's
  /// balls by more than kBallSpare, so that shapes do not touch. By bisection: a piece is free
  /// when, in its middle, balls that are larger by what they can move on half of the piece are (F.
  /// Schwarzer, M. Saha, J.-C. Latombe, "Exact collision checking of robot paths", WAFR 2002):
  /// their way at the speed that they have in the middle, and what they can be beside it by the
  /// chain's lengths. Between the robot's own parts it is the way of one as seen from the other.
  /// Shapes of another checker are larger by what their farthest point can move; the robot's own
  /// are tested at the middles only, at steps of at most 0.05 rad or m.
  bool is_swept_free(const Eigen::Ref<const Eigen::VectorXd>& from,
                     const Eigen::Ref<const Eigen::VectorXd>& to) const override;

 private:
  /// A ball that touches an obstacle, or another ball.
  struct Touch {
    int ball = -1;  // none
    int other = -1;
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
  };
  Touch first_touch(const Eigen::Ref<const Eigen::VectorXd>& q) const;
  /// By the shapes, and of the balls only those that are held. `swell`: m for each joint, or null.
  bool do_shapes_touch(const Eigen::Ref<const Eigen::VectorXd>& q, const double* swell) const;
  bool are_shapes_free_between(const Eigen::Ref<const Eigen::VectorXd>& from,
                               const Eigen::Ref<const Eigen::VectorXd>& to, int steps) const;
  bool are_shapes_swept_free(const Eigen::Ref<const Eigen::VectorXd>& from,
                             const Eigen::Ref<const Eigen::VectorXd>& to) const;
  /// Positions at `shares` of the way, as touching_lanes() takes them; the last one fills up.
  void fill_lanes(const Eigen::Ref<const Eigen::VectorXd>& from,
                  const Eigen::Ref<const Eigen::VectorXd>& to, const double* shares,
                  std::size_t count, float* q) const;
  void hold(const std::vector<RobotSphere>& balls_T);
  void let_go();
  void compile();
  void find_levers();
  SweepBounds sweep_bounds(const robot::Positions& way) const;

  robot::KinematicChain chain_;
  RobotSpheres spheres_;
  CollisionWorld world_;
  double margin_;
  std::size_t own_;  // spheres that are not attached
  std::size_t own_pairs_;
  std::shared_ptr<const BatchScene> own_batch_;  // of the robot alone, with nothing round it
  BatchScene batch_;
  /// m: the way of a ball of joint k is at most (k, j) for each radian (for each m: 1) of joint j.
  Eigen::MatrixXd levers_;
  std::shared_ptr<const ShapesInWorld> shapes_;  // null: balls are tested
};

}  // namespace prehend::motion
