#pragma once

#include "prehend/fidelity/front.h"
#include "prehend/shape/completion_options.h"
#include "prehend/surface/model.h"

namespace prehend::fidelity {

/// What turns a segmented cloud into a mesh.
struct ShapeOptions {
  shape::CompletionOptions completion;
  surface::ModelOptions model;
};

/// The options of a setting of the front "shape". Knobs (all optional; absent: the library's
/// default):
///   thinning      voxels in which one point each votes, as a fraction of the extent
///   orientations  of the plane that are tried
///   shifts        of the plane that are tried
///   alternatives  shapes by other planes on which grasps are tried, too
///   refine        yes | no: bisection round the best planes
///   spacing       m, leaf of the voxels that are meshed; 0: 1/90 of the extent
///   surface       fast | pcl: fast_poisson or pcl_poisson
///   resolution    nodes of the grid (fast) or depth of the octree (pcl)
///   pieces        m, how far a convex piece may reach beyond the mesh
/// @throws geometry::InputError naming a knob that is unknown or has a value it cannot have.
ShapeOptions shape_options(const Setting& setting);

}  // namespace prehend::fidelity
