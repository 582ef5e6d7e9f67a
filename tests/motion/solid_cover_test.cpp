#include "prehend/motion/solid_cover.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/surface_samples.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using geometry::TriangleMesh;

TriangleMesh moved_by(TriangleMesh mesh, const Vector3d& by) {
  for (Vector3d& p : mesh.vertices) p += by;
  return mesh;
}

/// A bracket of two boxes that overlap, and a bent bar, both far from convex.
std::vector<TriangleMesh> solids() {
  const TriangleMesh bracket = geometry::concatenated(
      {geometry::make_box({0.3, 0.05, 0.05}),
       moved_by(geometry::make_box({0.05, 0.05, 0.25}), {0.14, 0.01, 0.11})});
  const TriangleMesh bowl = geometry::make_revolution(
      {{0.02, 0}, {0.1, 0.05}, {0.12, 0.15}, {0.11, 0.15}, {0.09, 0.06}, {0.01, 0.012}}, 40);
  return {geometry::make_sphere(0.12, 32), geometry::make_box({0.001, 0.2, 0.3}), bracket, bowl};
}

TEST(SolidCover, HoldsTheWholeSolidAndLittleElse) {
  for (const TriangleMesh& solid : solids()) {
    const geometry::MeshQuery query(solid);
    const Eigen::AlignedBox3d box = query.box();
    for (const double resolution : {0.02, 0.06, 0.5}) {
      const std::vector<Ball> balls = cover_solid(solid, resolution);
      const auto held = [&](const Vector3d& p) {
        for (const Ball& ball : balls) {
          if ((p - ball.center).norm() <= ball.radius) return true;
        }
        return false;
      };
      for (const geometry::SurfaceSample& sample : geometry::surface_samples(solid, 2000, 1)) {
        ASSERT_TRUE(held(sample.point)) << resolution;
      }
      // A grid, off the solids' own.
      int inside = 0;
      const Vector3d step = box.sizes() / 23.7;
      for (int i = 0; i < 24 * 24 * 24; ++i) {
        const Vector3d p =
            box.min() + Vector3d(i % 24 + 0.3, i / 24 % 24 + 0.3, i / 576 + 0.3).cwiseProduct(step);
        if (!query.contains(p)) continue;
        ++inside;
        ASSERT_TRUE(held(p)) << resolution;
      }
      EXPECT_GT(inside, 100);
      for (const Ball& ball : balls) {
        for (const Vector3d& way : {Vector3d(1, 0, 0), Vector3d(-1, 0, 0), Vector3d(0, 1, 0),
                                    Vector3d(0, -1, 0), Vector3d(0, 0, 1), Vector3d(0, 0, -1)}) {
          EXPECT_LT(query.signed_distance(ball.center + ball.radius * way), resolution + 1e-6);
        }
      }
    }
  }
}

TEST(SolidCover, TakesFewBallsForWhatIsThick) {
  EXPECT_LE(cover_solid(geometry::make_sphere(0.12, 32), 0.02).size(), 2u);
}

TEST(SolidCover, RefusesWhatCannotBe) {
  const TriangleMesh box = geometry::make_box({1, 1, 1});
  EXPECT_THROW(cover_solid(box, 0), std::invalid_argument);
  EXPECT_THROW(cover_solid(box, std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  EXPECT_THROW(cover_solid(box, 0.003), geometry::InputError);
  EXPECT_THROW(cover_solid({}, 0.1), geometry::InputError);
}

}  // namespace
}  // namespace prehend::motion
