#pragma once

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// The connected parts of a closed `mesh` that are solids of at least `least_share` times the
/// largest one's volume, or of twice that share of the widest one's area: of a head whose neck
/// nobody saw there may be little more than a shell. Parts that are inside out, the walls of
/// hollows that no opening leads to, go: nobody can have seen them. Empty when no part encloses a
/// volume.
geometry::TriangleMesh solid_parts(const geometry::TriangleMesh& mesh, double least_share);

}  // namespace prehend::surface
