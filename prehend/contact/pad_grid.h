#pragma once

namespace prehend::contact {

/// A rectangular field of texels on a flat face.
struct PadGrid {
  int rows = 14;
  int columns = 6;
  double width = 6 * 0.0034;    // m, along x: across the columns
  double length = 14 * 0.0034;  // m, along y: across the rows, row 0 at +y
  double thickness = 0.003;     // m, of the foam: the deepest penetration
};

}  // namespace prehend::contact
