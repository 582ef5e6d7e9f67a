#pragma once

#include <cstdint>
#include <vector>

#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/grasp/known/point_features.h"

namespace prehend::grasp {

/// A model ready to be found.
struct RegisteredModel {
  geometry::MeshQuery surface_O;
  DescribedPoints samples_O;
  FeatureIndex index;
};

/// Seen points and their unit normals.
struct OrientedPoints {
  std::vector<Eigen::Vector3d> points, normals;  // n, m
};

struct ConsensusOptions {
  double spacing = 0.005;        // m, of the points on both sides
  double least_distance = 0.03;  // m, between the points of a pair: longer ones give better poses
  double tolerance = 0.006;      // m
  int samples = 150000;          // pairs
  int kept = 20;                 // poses
  std::uint64_t seed = 1;
};

/// Poses X_OS of the seen points (frame S) on the model that at least two of them agree with, by
/// place and normal, the best first and no two alike: prerejective sample consensus (Buch et al.,
/// ICRA 2013, section III) over pairs of oriented points (Drost et al., CVPR 2010).
std::vector<geometry::RigidTransform> consensus_poses(const DescribedPoints& seen_S,
                                                      const RegisteredModel& model,
                                                      const ConsensusOptions& options);

/// Point-to-plane ICP (Chen and Medioni 1992) of the seen points onto the model's surface, from
/// X_OS on. Points further away than a bound, which shrinks from 7.5 to 2 tolerances, do not count,
/// nor those that look another way than the surface: the far side of a thin wall.
geometry::RigidTransform refined_pose(const OrientedPoints& seen_S,
                                      const geometry::MeshQuery& surface_O,
                                      const geometry::RigidTransform& X_OS, double tolerance);

/// Share of the points within `tolerance` of the surface, and their root mean square distance [m].
struct Explained {
  double share = 0;
  double residual = 0;
};
Explained explained_by(const std::vector<Eigen::Vector3d>& points_S,
                       const geometry::MeshQuery& surface_O, const geometry::RigidTransform& X_OS,
                       double tolerance);

}  // namespace prehend::grasp
