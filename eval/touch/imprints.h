#pragma once

#include <string>
#include <vector>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::eval::touch {

enum class HoleShape { kCross, kSquare };
const char* to_string(HoleShape shape);

/// A cube of `size` [m] centred at the origin with a hole along y, its middle at (x, z) =
/// `hole_center` [m]. Cross: two bars, 6 mm wide and 18 mm long;
/// square: 12 mm wide.
geometry::TriangleMesh perforated_cube(HoleShape shape, double size,
                                       const Eigen::Vector2d& hole_center);

/// True where `shape`, centred at the origin, has its hole; x, z [m].
bool in_hole(HoleShape shape, double x, double z);

/// Which of the two holes a tactile image (rows * columns, row 0 at the top, square texels of
/// `pitch` [m]) shows: that whose template, at its best place, agrees better with the texels that
/// feel nothing. `agreement` gets the intersection over union of each, if not null.
HoleShape recognise(const std::vector<double>& image, int rows, int columns, double pitch,
                    double* agreement = nullptr);

}  // namespace prehend::eval::touch
