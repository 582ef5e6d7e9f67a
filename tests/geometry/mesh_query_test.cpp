#include "prehend/geometry/mesh_query.h"

#include <limits>
#include <random>

#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"

namespace prehend::geometry {
namespace {

TEST(MeshQuery, RaysMeetABoxWhereTheyShould) {
  const MeshQuery query(make_box({0.2, 0.4, 0.6}));
  const auto hit = query.cast_ray({1, 0.05, 0.1}, {-1, 0, 0});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance, 0.9, 1e-12);
  EXPECT_TRUE(hit->normal.isApprox(Eigen::Vector3d::UnitX()));
  EXPECT_FALSE(query.cast_ray({1, 0.05, 0.1}, {-1, 0, 0}, 0.89));
  EXPECT_FALSE(query.cast_ray({1, 0.5, 0.1}, {-1, 0, 0}));
}

TEST(MeshQuery, SignedDistanceToABoxMatchesTheClosedForm) {
  const Eigen::Vector3d half(0.1, 0.2, 0.3);
  const MeshQuery query(make_box(2 * half));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> around(-0.5, 0.5);
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d p(around(random), around(random), around(random));
    const Eigen::Vector3d q = p.cwiseAbs() - half;
    const double exact = q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
    if (std::abs(exact) < 1e-6) continue;
    EXPECT_NEAR(query.signed_distance(p), exact, 1e-9) << p.transpose();
  }
}

// Once NaN, which then beat every real triangle.
TEST(MeshQuery, TrianglesWithoutAreaAreTheirSides) {
  TriangleMesh mesh = make_box({0.2, 0.2, 0.2});
  const int first = static_cast<int>(mesh.vertices.size());
  for (const double x : {0.3, 0.35, 0.4}) mesh.vertices.emplace_back(x, 0, 0);
  mesh.triangles.emplace_back(first, first + 1, first + 2);  // in a line
  mesh.triangles.emplace_back(first, first, first + 2);      // two corners
  mesh.triangles.emplace_back(first, first, first);          // a point
  const MeshQuery query(mesh);
  EXPECT_NEAR(query.nearest({0.33, 0.03, 0})->distance, 0.03, 1e-9);
  EXPECT_NEAR(query.nearest({0.5, 0, 0})->distance, 0.1, 1e-9);
  EXPECT_NEAR(query.nearest({0.3, 0.02, 0})->distance, 0.02, 1e-9);
  EXPECT_NEAR(query.nearest({-0.15, 0, 0})->distance, 0.05, 1e-9);
}

TEST(MeshQuery, RaysSideBySideMeetWhatSingleOnesMeet) {
  const MeshQuery query(make_sphere(0.1, 48));
  const Eigen::Vector3d direction = Eigen::Vector3d(0.2, -0.1, -1).normalized();
  std::vector<Eigen::Vector3d> origins;
  for (int i = 0; i < 203; ++i) {  // no multiple of any packet
    origins.emplace_back(-0.12 + 0.24 * (i % 17) / 16, -0.12 + 0.24 * (i / 17) / 11, 0.3);
  }
  std::vector<std::optional<RayHit>> hits;
  int met = 0;
  for (const double reach : {1e9, 0.25}) {
    query.cast_rays(origins, direction, reach, &hits);
    ASSERT_EQ(hits.size(), origins.size());
    for (std::size_t i = 0; i < origins.size(); ++i) {
      const auto single = query.cast_ray(origins[i], direction, reach);
      ASSERT_EQ(hits[i].has_value(), single.has_value()) << i;
      if (!single) continue;
      ++met;
      EXPECT_NEAR(hits[i]->distance, single->distance, 1e-6);
    }
  }
  EXPECT_GT(met, 100);
  query.cast_rays({}, direction, 1, &hits);
  EXPECT_TRUE(hits.empty());
}

TEST(MeshQuery, NearestRespectsTheLimit) {
  const MeshQuery query(make_sphere(0.1, 64));
  EXPECT_FALSE(query.nearest({1, 0, 0}, 0.5));
  const auto near = query.nearest({1, 0, 0}, 2.0);
  ASSERT_TRUE(near);
  EXPECT_NEAR(near->distance, 0.9, 1e-9);
}

TEST(MeshQuery, SurvivesBeingMovedAndHandlesSmallAndLargeMeshes) {
  for (const double scale : {1e-3, 10.0}) {
    MeshQuery first(make_box(Eigen::Vector3d::Constant(scale)));
    const MeshQuery second = std::move(first);
    EXPECT_NEAR(second.signed_distance({0, 0, 0}), -scale / 2, 1e-9 * scale);
    EXPECT_NEAR(second.signed_distance({scale, 0, 0}), scale / 2, 1e-6 * scale);
  }
}

TEST(MeshQuery, RefusesMeshesThatCannotBeQueried) {
  EXPECT_THROW(MeshQuery{TriangleMesh{}}, InputError);
  TriangleMesh out_of_range = make_box({1, 1, 1});
  out_of_range.triangles[0][0] = 8;
  EXPECT_THROW(MeshQuery{out_of_range}, InputError);
  TriangleMesh with_nan = make_box({1, 1, 1});
  with_nan.vertices[0].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(MeshQuery{with_nan}, InputError);
}

}  // namespace
}  // namespace prehend::geometry
