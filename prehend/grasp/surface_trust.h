#pragma once

#include <optional>

#include <Eigen/Core>

#include "prehend/geometry/mesh_query.h"
#include "prehend/surface/object_model.h"

namespace prehend::grasp {

/// What is known of the surface at a point.
struct SurfaceTrust {
  double unseen = 0;  // 0..1: share of the triangle's vertices that nobody saw
  double there = 1;   // 0..1: that it is there, by vertex_confidence; without it what was seen is
};

/// Of the surface nearest to `p_W`. None where nothing is known of the object's surface.
/// @pre `query` is of the object's mesh.
std::optional<SurfaceTrust> surface_trust(const surface::ObjectModel& object,
                                          const geometry::MeshQuery& query,
                                          const Eigen::Vector3d& p_W);

}  // namespace prehend::grasp
