#pragma once

#include <vector>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::eval {

/// Where a body that is set down gently at X_WB comes to rest on the table z = 0. It rolls and
/// tilts as weight and contact tell (simulation::World), but never gathers speed: scanned meshes
/// have uneven feet, and what stands on the scan's z = 0 need not stand on its feet. The middle of
/// its bounds is over the origin; but among `others_W`, which do not move, it rests where it is.
/// @param mass kg, > 0; @param time_limit s, simulated, after which it counts as resting
/// @throws geometry::InputError for a mesh that encloses no volume.
geometry::RigidTransform resting_pose(const geometry::TriangleMesh& mesh_B,
                                      const geometry::RigidTransform& X_WB, double mass,
                                      const std::vector<geometry::TriangleMesh>& others_W = {},
                                      double time_limit = 60);

/// How far a body went from where it was put.
struct Settled {
  double moved = 0;   // m, its centre of mass
  double turned = 0;  // rad
};

/// Puts a solid of uniform density where `mesh_W` says, at rest, on the table z = 0 and among
/// `others_W`, which do not move, and lets it go for `duration` [s, simulated] (simulation::World,
/// with speed, unlike resting_pose()). One that reaches below the table is raised first, which
/// counts as having moved. `mass` in kg, > 0.
/// @throws geometry::InputError for a mesh that encloses no volume.
Settled settled(const geometry::TriangleMesh& mesh_W, double mass,
                const std::vector<geometry::TriangleMesh>& others_W = {}, double duration = 3);

}  // namespace prehend::eval
