#include "prehend/robot/formats/uniform_inertial.h"

#include <vector>

#include "prehend/geometry/errors.h"

namespace prehend::robot::formats {

std::optional<Inertial> uniform_inertial(const LinkDescription& link, ShapeMeshes& meshes,
                                         double density) {
  std::vector<geometry::TriangleMesh> solids;
  for (const Shape& shape : link.collisions.empty() ? link.visuals : link.collisions) {
    try {
      geometry::TriangleMesh mesh = meshes.of(shape);
      if (mesh.triangles.empty()) continue;
      if (!geometry::find_defects(mesh).watertight() ||
          !(geometry::mass_properties(mesh).volume > 0)) {
        mesh = geometry::convex_hull(mesh.vertices);
      }
      solids.push_back(geometry::transformed(mesh, shape.X_LS));
    } catch (const geometry::InputError&) {
      continue;  // check_model() says what is wrong with it
    }
  }
  if (solids.empty()) return std::nullopt;
  const auto filled = geometry::mass_properties(geometry::concatenated(solids));
  if (!(filled.volume > 0)) return std::nullopt;
  Inertial inertial;
  inertial.mass = density * filled.volume;
  inertial.X_LI.translation() = filled.center_of_mass;
  inertial.inertia = density * filled.unit_density_inertia;
  return inertial;
}

}  // namespace prehend::robot::formats
