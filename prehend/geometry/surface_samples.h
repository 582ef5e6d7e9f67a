#pragma once

#include <cstdint>
#include <vector>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::geometry {

struct SurfaceSample {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  int triangle = 0;
};

/// `samples` points [m] distributed uniformly over the area of `mesh`, one in each of as many equal
/// parts of it; the same seed gives the same points.
/// @throws InputError for a mesh without area, std::invalid_argument for samples < 1.
std::vector<SurfaceSample> surface_samples(const TriangleMesh& mesh, int samples,
                                           std::uint64_t seed);

}  // namespace prehend::geometry
