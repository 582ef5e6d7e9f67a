// The library alone, without messages and processes.

#include <cstdio>

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/surface/convex_pieces.h"

int main() {
  const auto box = prehend::geometry::make_box({0.06, 0.04, 0.12});
  const auto pieces = prehend::surface::convex_pieces(box);
  std::printf("a box of %.0f cm^3 is %zu convex piece\n",
              1e6 * prehend::geometry::mass_properties(box).volume, pieces.pieces.size());
}
