#include "prehend/surface/convex_pieces.h"

#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/surface/sampled_solid.h"

namespace prehend::surface {
namespace {

void expect_closed_and_convex(const geometry::TriangleMesh& piece) {
  EXPECT_TRUE(geometry::find_defects(piece).watertight());
  EXPECT_GT(geometry::mass_properties(piece).volume, 0);
  const double tolerance = 1e-5 * geometry::bounds(piece).diagonal().norm();
  for (const Eigen::Vector3i& t : piece.triangles) {
    const Eigen::Vector3d& a = piece.vertices[t.x()];
    const Eigen::Vector3d n = (piece.vertices[t.y()] - a).cross(piece.vertices[t.z()] - a);
    if (n.norm() < 1e-14) continue;
    for (const Eigen::Vector3d& p : piece.vertices) {
      ASSERT_LT(n.normalized().dot(p - a), tolerance);
    }
  }
}

/// Greatest distance of a surface point of `mesh` from the union of the pieces [m].
double uncovered(const geometry::TriangleMesh& mesh,
                 const std::vector<geometry::TriangleMesh>& pieces) {
  std::vector<geometry::MeshQuery> queries;
  for (const auto& piece : pieces) queries.emplace_back(piece);
  double worst = 0;
  for (const Eigen::Vector3d& p : sample_surface(mesh, 5000, 1)) {
    double least = 1e9;
    for (const auto& query : queries) least = std::min(least, query.signed_distance(p));
    worst = std::max(worst, least);
  }
  return worst;
}

double volume(const std::vector<geometry::TriangleMesh>& pieces) {
  double sum = 0;
  for (const auto& piece : pieces) sum += geometry::mass_properties(piece).volume;
  return sum;
}

TEST(ConvexPieces, OfAConvexSolidAreItsHull) {
  for (const auto& solid :
       {subdivided(geometry::make_box({0.06, 0.08, 0.1}), 3), geometry::make_sphere(0.05, 64)}) {
    const auto pieces = convex_pieces(solid);
    ASSERT_EQ(pieces.size(), 1u);
    expect_closed_and_convex(pieces[0]);
    EXPECT_NEAR(volume(pieces) / geometry::mass_properties(solid).volume, 1, 0.06);
  }
}

TEST(ConvexPieces, OfAnLCoverItWithoutFillingTheCorner) {
  const auto solid = subdivided(make_l_shape(0.05), 3);
  const auto pieces = convex_pieces(solid);
  EXPECT_GE(pieces.size(), 2u);
  EXPECT_LE(pieces.size(), 12u);
  for (const auto& piece : pieces) expect_closed_and_convex(piece);
  EXPECT_LT(uncovered(solid, pieces), 0.002);
  // The corner cut out of the L stays empty.
  for (const auto& piece : pieces) {
    EXPECT_GT(geometry::MeshQuery(piece).signed_distance({0.085, 0.085, 0.025}), 0.005);
  }
}

TEST(ConvexPieces, OfARingLeaveItsHoleOpen) {
  const auto solid = subdivided(make_ring(0.05, 0.035, 0.03), 1);
  const auto pieces = convex_pieces(solid);
  EXPECT_GE(pieces.size(), 4u);
  EXPECT_LE(pieces.size(), 40u);
  for (const auto& piece : pieces) {
    expect_closed_and_convex(piece);
    EXPECT_GT(geometry::MeshQuery(piece).signed_distance({0, 0, 0.015}), 0.015);
  }
  EXPECT_LT(uncovered(solid, pieces), 0.003);
}

TEST(ConvexPieces, SayNothingOnStandardOutput) {
  testing::internal::CaptureStdout();
  convex_pieces(subdivided(make_l_shape(0.05), 2));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST(ConvexPieces, AreTheSameEveryTime) {
  const auto solid = subdivided(make_l_shape(0.05), 2);
  const auto first = convex_pieces(solid);
  const auto second = convex_pieces(solid);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].vertices, second[i].vertices);
    EXPECT_EQ(first[i].triangles, second[i].triangles);
  }
}

TEST(ConvexPieces, HostileInputIsRefused) {
  EXPECT_THROW(convex_pieces({}), geometry::InputError);
  geometry::TriangleMesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_THROW(convex_pieces(flat), geometry::InputError);
  auto box = geometry::make_box({1, 1, 1});
  box.vertices[0].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(convex_pieces(box), geometry::InputError);
  box = geometry::make_box({1, 1, 1});
  box.triangles[0].x() = 99;
  EXPECT_THROW(convex_pieces(box), geometry::InputError);
  ConvexPiecesOptions options;
  options.concavity = 0;
  EXPECT_THROW(convex_pieces(geometry::make_box({1, 1, 1}), options), std::invalid_argument);
}

TEST(Thinned, HasFewTrianglesAndNearlyTheSameShape) {
  const auto sphere = geometry::make_sphere(0.05, 128);
  const auto few = thinned(sphere, 500);
  EXPECT_LE(few.triangles.size(), 500u);
  EXPECT_GT(few.triangles.size(), 150u);
  EXPECT_EQ(geometry::find_defects(few).boundary_edges, 0);
  EXPECT_LT(mesh_deviation(few, sphere).to_second.max, 0.003);
  EXPECT_EQ(thinned(few, 500).vertices, few.vertices);
}

}  // namespace
}  // namespace prehend::surface
