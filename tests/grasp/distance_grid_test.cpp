#include "prehend/grasp/closing/distance_grid.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/grasp/closing/distance_block.h"
#include "tests/grasp/hand_scene.h"

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;

/// Triangles of all shapes at random places of a decimetre: needles, points and flat ones, too.
geometry::TriangleMesh soup(std::mt19937_64& random, int triangles, double edge,
                            const Vector3d& at) {
  geometry::TriangleMesh mesh;
  for (int i = 0; i < triangles; ++i) {
    const auto vertex = [&](double size) {
      return Vector3d(size * random_unit(random), size * random_unit(random),
                      size * random_unit(random));
    };
    const Vector3d a = at + vertex(0.05), side = vertex(edge);
    const int kind = i % 8;
    const Vector3d c = kind == 0   ? a                                  // a point or a side
                       : kind == 1 ? Vector3d(a + 0.3 * side)           // on a line
                       : kind == 2 ? Vector3d(a + side + vertex(1e-7))  // a needle
                                   : Vector3d(a + vertex(edge));
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(),
                         {a, kind == 0 && i % 16 == 0 ? a : Vector3d(a + side), c});
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  return mesh;
}

void expect_as_single_queries(const geometry::MeshQuery& mesh, const Vector3d& first, double cell,
                              double tolerance) {
  const DistanceBlock block = DistanceBlocks(mesh).measure(first, cell);
  for (int i = 0; i < static_cast<int>(block.size()); ++i) {
    const Vector3d p = first + cell * Vector3d(i % 4, i / 4 % 4, i / 16);
    ASSERT_NEAR(block[static_cast<std::size_t>(i)], mesh.nearest(p)->distance, tolerance)
        << "node " << i << " of the block at " << first.transpose();
  }
}

TEST(DistanceBlock, IsWhatSingleQueriesFind) {
  std::mt19937_64 random(5);
  for (const double edge : {0.002, 0.02, 0.2}) {
    for (const double away : {0.0, 1.0}) {
      const Vector3d at(away, -away, 0);
      const geometry::MeshQuery mesh(soup(random, 200, edge, at));
      for (int i = 0; i < 60; ++i) {
        const Vector3d first = at + Vector3d(0.1 * random_unit(random), 0.1 * random_unit(random),
                                             0.1 * random_unit(random));
        // Embree's own boxes are of single precision, too.
        expect_as_single_queries(mesh, first, 0.0025, 1e-7 + 2e-7 * away);
      }
    }
  }
}

TEST(DistanceBlock, OfScalesFarFromAHandsToo) {
  for (const double scale : {1e-4, 1.0, 100.0}) {
    const geometry::MeshQuery ball(geometry::make_sphere(0.04 * scale, 48));
    for (const double distance : {0.0, 0.03, 0.04, 0.05, 0.4, 40.0}) {
      expect_as_single_queries(ball, scale * distance * Vector3d(0.6, 0, 0.8), 0.0025 * scale,
                               2e-6 * scale * (0.04 + distance));
    }
  }
}

TEST(DistanceBlock, ABoundThatIsWrongIsFoundOut) {
  const geometry::MeshQuery ball(geometry::make_sphere(0.04, 48));
  const Vector3d first(0.05, 0, 0);
  const DistanceBlocks blocks(ball);
  EXPECT_EQ(blocks.measure(first, 0.0025, 0.001), blocks.measure(first, 0.0025));
}

TEST(DistanceGrid, IsTheDistanceNearAndBelowItFar) {
  const geometry::MeshQuery ball(geometry::make_sphere(0.04, 96));
  const DistanceGrid grid(ball);
  std::mt19937_64 random(3);
  for (int i = 0; i < 3000; ++i) {
    const Vector3d p(0.12 * random_unit(random), 0.12 * random_unit(random),
                     0.12 * random_unit(random));
    const double exact = ball.nearest(p)->distance, got = grid.distance(p);
    if (got <= DistanceGrid::kNear) {
      // cell^2 / (4 r) with r the ball's radius and more.
      EXPECT_NEAR(got, exact, p.norm() > 0.045 ? 5e-5 : 1.3e-3) << p.norm();
      if (p.norm() > 0.045) {
        EXPECT_GT(grid.away(p).dot(p.normalized()), 0.999);
      }
    } else {
      EXPECT_LE(got, exact + 5e-5);
      EXPECT_GT(got, DistanceGrid::kNear);
    }
  }
  EXPECT_THROW(DistanceGrid(ball, 0), std::invalid_argument);
  EXPECT_THROW(DistanceGrid(ball, 0.002, std::nan("")), std::invalid_argument);
}

// A table full of things has one grid; what would take too many nodes is asked directly.
TEST(DistanceGrid, IsOfThingsFarApartToo) {
  for (const double apart : {0.9, 4.0}) {
    geometry::TriangleMesh things = geometry::make_sphere(0.04, 48);
    const geometry::TriangleMesh other = geometry::transformed(
        things, geometry::RigidTransform(Eigen::Translation3d(apart, apart, apart / 3)));
    const auto first = static_cast<int>(things.vertices.size());
    things.vertices.insert(things.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const Eigen::Vector3i& t : other.triangles) {
      things.triangles.emplace_back(t.array() + first);
    }
    const geometry::MeshQuery both(things);
    const DistanceGrid grid(both);
    std::mt19937_64 random(11);
    for (int i = 0; i < 300; ++i) {
      const Vector3d away =
          Vector3d(random_unit(random), random_unit(random), random_unit(random)).normalized();
      const Vector3d p = (i % 2 == 0 ? Vector3d(0, 0, 0) : Vector3d(apart, apart, apart / 3)) +
                         (0.042 + 0.004 * std::abs(random_unit(random))) * away;
      EXPECT_NEAR(grid.distance(p), both.nearest(p)->distance, 1e-4) << apart;
      EXPECT_GT(grid.away(p).dot(away), 0.99);
    }
  }
}

// Whoever fills a block first, its nodes are the same.
TEST(DistanceGrid, IsTheSameForSeveralWhoAskAtOnce) {
  const geometry::MeshQuery ball(geometry::make_sphere(0.04, 48));
  const DistanceGrid alone(ball), shared(ball);
  std::mt19937_64 random(7);
  std::vector<Vector3d> points;
  for (int i = 0; i < 2000; ++i) {
    points.emplace_back(0.06 * random_unit(random), 0.06 * random_unit(random),
                        0.06 * random_unit(random));
  }
  std::vector<double> expected;
  for (const Vector3d& p : points) expected.push_back(alone.distance(p));
  std::vector<std::vector<double>> got(3);
  std::vector<std::jthread> threads;
  for (std::size_t i = 0; i < got.size(); ++i) {
    threads.emplace_back([&, i] {
      for (const Vector3d& p : points) got[i].push_back(shared.distance(p));
    });
  }
  threads.clear();
  for (const auto& one : got) EXPECT_EQ(one, expected);
}

}  // namespace
}  // namespace prehend::grasp
