#include "prehend/surface/delaunay.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "tests/shape/synthetic_view.h"

namespace prehend::surface {
namespace {

using geometry::TriangleMesh;
using shape::SyntheticView;

TriangleMesh surface_of(const SyntheticView& view, const DelaunayOptions& options = {}) {
  return delaunay_surface(view.cloud_W, view.camera, view.X_WC, options);
}

TEST(Delaunay, OfAViewedBoxIsItsFrontClosed) {
  const TriangleMesh box = shape::standing(geometry::make_box({0.06, 0.09, 0.12}), 0.5);
  const SyntheticView view = shape::synthetic_view(box, {});
  const TriangleMesh mesh = surface_of(view);
  EXPECT_TRUE(geometry::find_defects(mesh).watertight())
      << geometry::find_defects(mesh).to_string();
  const geometry::MassProperties properties = geometry::mass_properties(mesh);
  const double whole = 0.06 * 0.09 * 0.12;
  EXPECT_GT(properties.volume, 0.2 * whole);
  EXPECT_LT(properties.volume, 0.7 * whole);
  // Nothing of the far side was predicted: the centre lies towards the camera.
  const Eigen::Vector3d towards = view.X_WC.translation() - geometry::bounds(box).center();
  EXPECT_GT((properties.center_of_mass - geometry::bounds(box).center()).dot(towards), 0);
  EXPECT_GE(mesh.vertices.size(), 490u);
  EXPECT_LE(mesh.vertices.size(), 500u);
}

// The baseline spans its closing triangles between the contour's edges. Once they met in a vertex
// of their own, in the contour's middle, which nobody had seen.
TEST(Delaunay, EveryVertexWasSeen) {
  for (const geometry::TriangleMesh& solid :
       {geometry::make_box({0.06, 0.09, 0.12}), geometry::make_revolution({{0.04, 0}, {0.04, 0.1}}),
        geometry::make_sphere(0.05)}) {
    const SyntheticView view =
        shape::synthetic_view(shape::standing(solid, 0.5), {.depth_noise = 0.001});
    const TriangleMesh mesh = surface_of(view);
    EXPECT_TRUE(geometry::find_defects(mesh).watertight())
        << geometry::find_defects(mesh).to_string();
    const std::set<std::array<float, 3>> seen = [&] {
      std::set<std::array<float, 3>> all;
      for (const auto& p : view.cloud_W.points) all.insert({p.x(), p.y(), p.z()});
      return all;
    }();
    for (const Eigen::Vector3d& vertex : mesh.vertices) {
      const Eigen::Vector3f p = vertex.cast<float>();
      ASSERT_TRUE(seen.count({p.x(), p.y(), p.z()})) << vertex.transpose();
    }
  }
}

// A view of an L seen from above: what is spanned behind the contour stays within it.
TEST(Delaunay, ClosingStaysWithinAConcaveContour) {
  const TriangleMesh angle = geometry::concatenated(
      {geometry::make_box({0.12, 0.03, 0.02}),
       geometry::transformed(
           geometry::make_box({0.03, 0.12, 0.02}),
           geometry::make_transform(Eigen::Quaterniond::Identity(), {-0.045, 0.075, 0}))});
  const SyntheticView view = shape::synthetic_view(shape::standing(angle, 0), {});
  const TriangleMesh mesh = surface_of(view, {.samples = 1500});
  ASSERT_TRUE(geometry::find_defects(mesh).watertight());
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  int beside = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d middle =
        (mesh.vertices[t.x()] + mesh.vertices[t.y()] + mesh.vertices[t.z()]) / 3;
    const Eigen::Vector2d pixel = view.camera.project(X_CW * middle);
    beside +=
        view.mask.at(static_cast<int>(pixel.x() + 0.5), static_cast<int>(pixel.y() + 0.5)) == 0;
  }
  EXPECT_LT(beside, 0.01 * static_cast<double>(mesh.triangles.size()));
}

TEST(Delaunay, LongEdgesOverAGapGo) {
  // Two balls, of which the larger is kept.
  const TriangleMesh balls =
      geometry::concatenated({shape::standing(geometry::make_sphere(0.04), 0, 0, -0.08),
                              shape::standing(geometry::make_sphere(0.03), 0, 0, 0.08)});
  const TriangleMesh mesh = surface_of(shape::synthetic_view(balls, {}));
  EXPECT_TRUE(geometry::find_defects(mesh).watertight());
  EXPECT_LT(geometry::bounds(mesh).max().y(), 0);
}

TEST(Delaunay, OrderOfThePointsDoesNotMatterAndTheSeedDoes) {
  SyntheticView view =
      shape::synthetic_view(shape::standing(geometry::make_sphere(0.05), 0), {.width = 320});
  const TriangleMesh first = surface_of(view);
  EXPECT_NE(first.vertices, surface_of(view, {.seed = 2}).vertices);
  std::reverse(view.cloud_W.points.begin(), view.cloud_W.points.end());
  EXPECT_EQ(first.vertices, surface_of(view).vertices);
}

TEST(Delaunay, IsWatertightForAnyFilter) {
  // Short longest edges leave rags that meet in single points, with holes.
  const SyntheticView view =
      shape::synthetic_view(shape::standing(geometry::make_revolution({{0.04, 0}, {0.04, 0.1}}), 0),
                            {.depth_noise = 0.002, .width = 320});
  for (const double longest : {1.05, 1.2, 1.5, 2.0, 3.0}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const TriangleMesh mesh = surface_of(view, {.longest_edge = longest, .seed = seed});
      ASSERT_FALSE(mesh.empty());
      ASSERT_TRUE(geometry::find_defects(mesh).watertight())
          << geometry::find_defects(mesh).to_string() << " at " << longest << " seed " << seed;
    }
  }
}

TEST(Delaunay, HostileInputIsRefused) {
  SyntheticView view =
      shape::synthetic_view(shape::standing(geometry::make_sphere(0.05), 0), {.width = 160});
  EXPECT_THROW(surface_of(view, {.samples = 2}), std::invalid_argument);
  EXPECT_THROW(surface_of(view, {.longest_edge = 1}), std::invalid_argument);
  view.cloud_W.points[0] = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  EXPECT_NO_THROW(surface_of(view));  // as an organized cloud has them
  const Eigen::Vector3f p = view.cloud_W.points[1];
  view.cloud_W.points.assign(100, p);
  EXPECT_THROW(surface_of(view), geometry::InputError);
  for (int i = 0; i < 100; ++i) view.cloud_W.points[i].x() += 1e-4f * i;
  for (auto& q : view.cloud_W.points) q = view.X_WC.translation().cast<float>();
  EXPECT_THROW(surface_of(view), geometry::InputError);
  view.cloud_W.points.clear();
  EXPECT_THROW(surface_of(view), geometry::InputError);
}

}  // namespace
}  // namespace prehend::surface
