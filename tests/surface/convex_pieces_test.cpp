#include "prehend/surface/convex_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/oracles/reference_pieces.h"
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
    const auto pieces = convex_pieces(solid).pieces;
    ASSERT_EQ(pieces.size(), 1u);
    expect_closed_and_convex(pieces[0]);
    EXPECT_NEAR(volume(pieces) / geometry::mass_properties(solid).volume, 1, 0.06);
  }
}

TEST(ConvexPieces, OfAnLCoverItWithoutFillingTheCorner) {
  const auto solid = subdivided(make_l_shape(0.05), 3);
  const auto pieces = convex_pieces(solid).pieces;
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
  const auto pieces = convex_pieces(solid).pieces;
  EXPECT_GE(pieces.size(), 4u);
  EXPECT_LE(pieces.size(), 40u);
  for (const auto& piece : pieces) {
    expect_closed_and_convex(piece);
    EXPECT_GT(geometry::MeshQuery(piece).signed_distance({0, 0, 0.015}), 0.015);
  }
  EXPECT_LT(uncovered(solid, pieces), 0.003);
}

struct Named {
  const char* name;
  geometry::TriangleMesh mesh;
  double concavity;  // [m]
};

/// A cup: a beaker of 3 mm walls, open above.
geometry::TriangleMesh make_cup() {
  return geometry::make_revolution(
      {{0, 0}, {0.04, 0}, {0.04, 0.1}, {0.037, 0.1}, {0.037, 0.004}, {0, 0.004}}, 96);
}

std::vector<Named> dented() {
  return {{"L", subdivided(make_l_shape(0.05), 3), 0.004},
          {"ring", subdivided(make_ring(0.05, 0.035, 0.03), 1), 0.004},
          {"torus", make_torus(0.04, 0.015, 100, 50), 0.004},
          {"cup", make_cup(), 0.004}};
}

TEST(ConvexPieces, CoverTheSolidAndReachNoFartherThanStated) {
  for (const Named& solid : dented()) {
    const ConvexPieces result =
        convex_pieces(solid.mesh, {.concavity = solid.concavity, .max_voxels = 64});
    EXPECT_GE(result.pieces.size(), 2u) << solid.name;
    EXPECT_LT(result.pieces.size(), 40u) << solid.name;
    EXPECT_LE(result.concavity, solid.concavity) << solid.name;
    EXPECT_LT(uncovered(solid.mesh, result.pieces), 0.0015) << solid.name;
    const geometry::MeshQuery truth(solid.mesh);
    for (const auto& piece : result.pieces) {
      expect_closed_and_convex(piece);
      for (const Eigen::Vector3d& p : sample_surface(piece, 500, 1)) {
        // The stated error is measured on voxels; half of one is what they can be off.
        EXPECT_LT(truth.signed_distance(p), solid.concavity + 0.001) << solid.name;
      }
    }
  }
}

/// Volume of the union of the pieces over the solid's, by points on a lattice.
double volume_ratio(const geometry::TriangleMesh& mesh,
                    const std::vector<geometry::TriangleMesh>& pieces) {
  const geometry::MeshQuery truth(mesh);
  std::vector<geometry::MeshQuery> queries;
  for (const auto& piece : pieces) queries.emplace_back(piece);
  const Eigen::AlignedBox3d box = geometry::bounds(mesh);
  int in_truth = 0;
  int in_pieces = 0;
  constexpr int kSteps = 40;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const Eigen::Array3d step(i % kSteps + 0.5, i / kSteps % kSteps + 0.5,
                              i / kSteps / kSteps + 0.5);
    const Eigen::Vector3d p = box.min().array() + step / kSteps * box.sizes().array();
    in_truth += truth.contains(p);
    in_pieces += std::any_of(queries.begin(), queries.end(),
                             [&](const auto& query) { return query.contains(p); });
  }
  return static_cast<double>(in_pieces) / in_truth;
}

TEST(ConvexPieces, HaveNearlyTheVolumeOfTheSolid) {
  const std::vector<Named> solids = dented();
  EXPECT_NEAR(volume_ratio(solids[0].mesh, convex_pieces(solids[0].mesh).pieces), 1, 0.03);
  EXPECT_NEAR(volume_ratio(solids[1].mesh, convex_pieces(solids[1].mesh).pieces), 1, 0.15);
  EXPECT_NEAR(volume_ratio(solids[2].mesh, convex_pieces(solids[2].mesh).pieces), 1, 0.1);
  // The cup's walls are thinner than the stated error, but its inside stays open.
  for (const auto& piece : convex_pieces(solids[3].mesh).pieces) {
    EXPECT_GT(geometry::MeshQuery(piece).signed_distance({0, 0, 0.06}), 0.02);
  }
}

TEST(ConvexPieces, AreFewerForALargerError) {
  const auto torus = make_torus(0.04, 0.015, 100, 50);
  const std::size_t fine = convex_pieces(torus, {.concavity = 0.003}).pieces.size();
  const std::size_t coarse = convex_pieces(torus, {.concavity = 0.01}).pieces.size();
  EXPECT_LT(coarse, fine);
  EXPECT_EQ(convex_pieces(torus, {.concavity = 1}).pieces.size(), 1u);
}

TEST(ConvexPieces, SayWhatTheyReachedWhenThatIsNotWhatWasAskedFor) {
  const auto torus = make_torus(0.04, 0.015, 100, 50);
  const ConvexPieces two = convex_pieces(torus, {.concavity = 0.003, .max_pieces = 2});
  EXPECT_LE(two.pieces.size(), 2u);
  EXPECT_GT(two.concavity, 0.01);
}

TEST(ConvexPieces, MoveWithTheSolidAndScaleWithIt) {
  const auto solid = subdivided(make_l_shape(0.05), 3);
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.linear() = Eigen::AngleAxisd(1, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  X.translation() << 10000, -3, 2;
  const auto here = convex_pieces(solid).pieces;
  const auto there = convex_pieces(geometry::transformed(solid, X)).pieces;
  ASSERT_EQ(here.size(), there.size());
  EXPECT_NEAR(volume(here), volume(there), 1e-3 * volume(here));
  for (const double scale : {0.01, 100.0}) {
    auto scaled = solid;
    for (auto& p : scaled.vertices) p *= scale;
    EXPECT_EQ(convex_pieces(scaled, {.concavity = 0.004 * scale}).pieces.size(), here.size());
  }
}

TEST(ReferencePieces, CoverTheLToo) {
  const auto solid = subdivided(make_l_shape(0.05), 2);
  testing::internal::CaptureStdout();  // HACD talks
  const auto by_hacd = hacd_pieces(solid);
  const auto by_ratcliff = ratcliff_pieces(solid);
  testing::internal::GetCapturedStdout();
  EXPECT_GE(by_hacd.size(), 2u);
  EXPECT_GE(by_ratcliff.size(), 1u);  // not the same every time
  for (const auto& piece : by_hacd) expect_closed_and_convex(piece);
  EXPECT_LT(uncovered(solid, by_hacd), 0.002);
  EXPECT_LT(uncovered(solid, by_ratcliff), 0.005);
}

TEST(ConvexPieces, AreTheSameEveryTime) {
  const auto solid = subdivided(make_l_shape(0.05), 2);
  const auto first = convex_pieces(solid).pieces;
  const auto second = convex_pieces(solid).pieces;
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
