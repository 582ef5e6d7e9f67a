#pragma once

#include <filesystem>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::robot::formats {

/// Whether a file's ending is of Inventor (.iv) or VRML (.wrl, .vrml), versions 1 and 2.
bool is_inventor_file(const std::filesystem::path& file);

/// All surfaces of a file of Inventor or VRML as one mesh, in its units, with the files that it
/// includes. @throws geometry::InputError naming the file and what Coin says of it: one that is
/// damaged, includes itself, has no surface, or one that Coin makes by a display (NURBS, texts);
/// indices beyond its points, prototypes, more than 200 levels, binary and packed files.
geometry::TriangleMesh read_inventor_mesh(const std::filesystem::path& file);

}  // namespace prehend::robot::formats
