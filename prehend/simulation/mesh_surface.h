#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/mesh_query.h"

/// What touching needs to know of a mesh's surface. All in the mesh's frame, m.
namespace prehend::simulation {

/// How deep a point is within a mesh's surface [m], negative outside, and the normal of the nearest
/// face; false when it is farther from the surface than `reach`.
bool mesh_depth(const geometry::MeshQuery& query, const Eigen::Vector3d& p, double reach,
                Eigen::Vector3d& normal, double& depth);

/// At points of the mesh's surface: unit, outward; on edges and corners of a mesh of few faces the
/// mean of those that meet there; zero where these have no area. @param query of the mesh, where
/// there is one.
std::vector<Eigen::Vector3d> normals_at(const std::vector<Eigen::Vector3d>& points,
                                        const geometry::TriangleMesh& mesh,
                                        std::shared_ptr<const geometry::MeshQuery> query = nullptr);

}  // namespace prehend::simulation
