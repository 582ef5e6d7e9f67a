#pragma once

#include <optional>

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/tracked_xml.h"

namespace prehend::robot::formats {

/// The <box>, <sphere>, <cylinder>, <capsule> or <plane> in a rigid body's <shape> or in OpenRAVE's
/// "geometry_info", with the steps beside it, as X_LS; none: there is none. A cylinder and a
/// capsule stand along z then, as in "geometry_info"; a body's along y. @throws
/// geometry::InputError with the place of one without sizes
/// @param length metres of the file's unit
std::optional<Shape> collada_solid(const XmlElement& element, double length);

/// Whether a solid is none without an inside: its sizes are more than 0 m, and finite.
bool has_inside(const Shape& solid);

/// Whether a mesh fills the box that the solid fills, to a hundredth: other writers' words about
/// their meshes are not always so.
bool is_same_solid(const Shape& solid, const geometry::TriangleMesh& mesh);

}  // namespace prehend::robot::formats
