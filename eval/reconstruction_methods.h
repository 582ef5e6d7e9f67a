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
  /// Of the scene's `object`th object. Throws when it cannot. Empty: takes the truth.
  std::function<Reconstruction(const perception::SegmentedScene&, std::size_t object)> reconstruct;
};

/// Every method:
///  - Ext, the fall-back: convex hull of the seen points and their feet on the table;
///  - Del: surface::delaunay_surface, without any prediction;
///  - Mir5, Mir7: the published completion and normals, Poisson reconstruction as of 2006 (without
///    screening) by pcl::Poisson at depth 5 and 7, nothing thinned or closed;
///  - Ours: the library's defaults;
///  - Fast: ours at the setting of config/fidelity/shape.yaml for 60 ms, from the source tree;
///  - Mirror: our plane of symmetry without its fall-backs and second plane, every mirrored point
///    kept, our Poisson reconstruction without closed sides and bottom, walls of vessels and empty
///    space. Mir5 and Mir7 are that as published;
///  - GPIS: gaussian_surface() of the seen points alone;
///  - Superquadric: fit_superquadric() of the seen points and their feet on the table, cut
///    at the table;
///  - Truth: the control.
std::vector<Method> known_methods();

/// Those of these names, in their order. @throws std::invalid_argument for an unknown one.
std::vector<Method> methods_named(const std::vector<std::string>& names);

}  // namespace prehend::eval
