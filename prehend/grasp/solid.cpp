#include "prehend/grasp/solid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "prehend/geometry/errors.h"

namespace prehend::grasp {

Solid make_solid(const geometry::TriangleMesh& mesh_W, double density) {
  const std::string mend = "Complete and mesh the object again";
  if (mesh_W.empty()) throw geometry::InputError("The object's mesh has no triangles", mend);
  const int vertices = static_cast<int>(mesh_W.vertices.size());
  for (const auto& t : mesh_W.triangles) {
    if (t.minCoeff() < 0 || t.maxCoeff() >= vertices) {
      throw geometry::InputError("The object's mesh has a triangle with an index out of range",
                                 mend);
    }
  }
  for (const auto& v : mesh_W.vertices) {
    if (!v.allFinite()) {
      throw geometry::InputError("The object's mesh has a vertex with NaN or infinity", mend);
    }
  }
  Solid solid;
  solid.mesh_W = mesh_W;
  geometry::MassProperties properties = geometry::mass_properties(mesh_W);
  if (properties.volume < 0) {
    for (auto& t : solid.mesh_W.triangles) std::swap(t[1], t[2]);
  }
  if (geometry::find_defects(mesh_W).watertight() && properties.volume != 0) {
    properties.volume = std::abs(properties.volume);
  } else {
    properties = geometry::mass_properties(geometry::convex_hull(mesh_W.vertices));
  }
  solid.mass = density * properties.volume;
  solid.center_of_mass_W = properties.center_of_mass;
  for (const auto& v : mesh_W.vertices) {
    solid.radius = std::max(solid.radius, (v - solid.center_of_mass_W).norm());
  }
  return solid;
}

}  // namespace prehend::grasp
