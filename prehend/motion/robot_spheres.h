#pragma once

#include <string>
#include <utility>
#include <vector>

#include "prehend/robot/kinematic_chain.h"

namespace prehend::motion {

/// A ball that moves with a joint's frame.
struct RobotSphere {
  int joint = -1;                                 // of the chain; -1: stands with the base
  Eigen::Vector3d p_J = Eigen::Vector3d::Zero();  // m, in the frame after that joint
  double radius = 0;                              // m
  int link = -1;                                  // of the model; -1: of none, as what is held
};

/// Every point of a shape is at least so deep in a ball [m]: by so much a ball may be in something
/// while the shape is not.
constexpr double kBallSpare = 1e-3;

using LinkPairs = std::vector<std::pair<std::string, std::string>>;

/// A robot's chain as balls that together hold all of its collision shapes.
struct RobotSpheres {
  std::vector<RobotSphere> spheres;
  /// Pairs of `spheres` that can touch each other and must not: those of links with at least one
  /// other moving link between them that do not overlap in the middle of the limits, without
  /// `apart_pairs`.
  std::vector<std::pair<int, int>> self_pairs;
  /// Those that touch at no position within the limits, as kept_apart() has proven. Not tested.
  std::vector<std::pair<int, int>> apart_pairs;

  /// Centres in the base frame [m] at `q`, in the order of `spheres`.
  void centers(const robot::KinematicChain& chain, const Eigen::Ref<const Eigen::VectorXd>& q,
               std::vector<Eigen::Vector3d>& centers) const;
};

/// Covers the shapes of all links that the chain carries (branches beside it included, their joints
/// at 0 or the middle of their limits) with balls: boxes, cylinders and spheres about `resolution`
/// [m] apart, or as far as the shape is thick, meshes by cover_solid(). Every point of a shape is
/// kBallSpare deep in a ball; beside that a ball reaches beyond a mesh by at most a fifth of
/// `resolution`, beyond another shape by at most 1.8 resolutions or half of its smallest side.
/// @param may_touch pairs of links that may touch each other, as an SRDF names them. All others
/// that
///     some joint moves against each other must not, but for balls that overlap in the middle of
///     the limits. Null: as `self_pairs` says
/// @throws std::invalid_argument for a resolution that is not positive; geometry::InputError for a
/// mesh that needs more than 20000 balls, a link that is not there, and as KinematicChain.
RobotSpheres make_robot_spheres(const robot::RobotModel& model, const std::string& base,
                                const std::string& tip, double resolution = 0.06,
                                const LinkPairs* may_touch = nullptr);

}  // namespace prehend::motion
