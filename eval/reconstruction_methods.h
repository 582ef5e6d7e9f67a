#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/perception/segmented_scene.h"
#include "prehend/shape/confidence.h"

namespace prehend::eval {

/// What a method makes of one seen object.
struct Reconstruction {
  geometry::TriangleMesh mesh_W;
  double vote = std::numeric_limits<double>::quiet_NaN();        // of the chosen plane, if any
  double confidence = std::numeric_limits<double>::quiet_NaN();  // 0..1, P(deviation < 5 mm)
  std::optional<shape::Evidence> evidence;                       // what the confidence is made of
};

/// A way from a seen object to its whole surface.
struct Method {
  std::string name;         // short, as in figures
  std::string description;  // one line
  /// Of the scene's `object`th object. Throws when it cannot.
  std::function<Reconstruction(const perception::SegmentedScene&, std::size_t object)> reconstruct;
};

/// The methods that are compared:
///  - Ext, the fall-back: convex hull of the seen points and their feet on the table;
///  - Del: surface::delaunay_surface, without any prediction;
///  - Mir5, Mir7: the published completion and normals, Poisson reconstruction as of 2006 (without
///    screening) by pcl::Poisson at depth 5 and 7, nothing thinned or closed;
///  - Ours: the library's defaults.
std::vector<Method> compared_methods();

}  // namespace prehend::eval
