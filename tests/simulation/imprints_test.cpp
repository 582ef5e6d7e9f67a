#include "eval/touch/imprints.h"

#include <gtest/gtest.h>

namespace prehend::eval::touch {
namespace {

TEST(Imprints, PerforatedCubesAreClosedSolids) {
  for (const HoleShape shape : {HoleShape::kCross, HoleShape::kSquare}) {
    const geometry::TriangleMesh mesh = perforated_cube(shape, 0.05, {0.003, 0.006});
    EXPECT_TRUE(geometry::find_defects(mesh).watertight())
        << geometry::find_defects(mesh).to_string();
    const double hole = shape == HoleShape::kCross ? 2 * 18 * 6 - 36 : 144;  // mm^2
    EXPECT_NEAR(geometry::mass_properties(mesh).volume, 0.05 * (2500 - hole) * 1e-6, 1e-12);
  }
}

TEST(Imprints, AreToldApartWhereverTheyAre) {
  for (const HoleShape shape : {HoleShape::kCross, HoleShape::kSquare}) {
    for (const double x : {-0.004, 0.0, 0.0021}) {
      for (const double z : {-0.01, 0.0013, 0.008}) {
        std::vector<double> image;
        for (int t = 0; t < 84; ++t) {
          const double dx = (t % 6 - 2.5) * 0.0034 - x, dz = (6.5 - t / 6) * 0.0034 - z;
          image.push_back(in_hole(shape, dx, dz) ? 0 : 100 + t % 7);
        }
        EXPECT_EQ(recognise(image, 14, 6, 0.0034), shape) << x << ", " << z;
      }
    }
  }
}

}  // namespace
}  // namespace prehend::eval::touch
