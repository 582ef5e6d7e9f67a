// Convex pieces as predicted shapes have them: slivers, wedges, sheets, needles. Each is an
// obstacle and can be held. Once a piece whose cover had a ball without radius ended the planning
// of all objects of a view, and a flat piece that of its own.

#include <algorithm>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "prehend/geometry/errors.h"
#include "prehend/motion/ball_cover.h"
#include "prehend/motion/collision_world.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

// Points in a box of these sides, turned at random.
geometry::TriangleMesh random_piece(std::mt19937_64& random, const Vector3d& sides) {
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  const auto vector = [&] { return Vector3d(uniform(random), uniform(random), uniform(random)); };
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond(uniform(random), uniform(random), uniform(random), uniform(random))
          .normalized();
  const Vector3d middle = vector();
  geometry::TriangleMesh piece;
  for (int i = 0; i < 8; ++i)
    piece.vertices.push_back(middle + turn * vector().cwiseProduct(sides));
  return piece;
}

// Of random pieces: compact, slivers, sheets and needles of 10 um, exact sheets, lines and points.
std::vector<geometry::TriangleMesh> degenerate_pieces() {
  std::mt19937_64 random(7);
  std::vector<geometry::TriangleMesh> pieces;
  for (const Vector3d& sides :
       {Vector3d(0.08, 0.05, 0.06), Vector3d(0.08, 0.05, 0.002), Vector3d(0.1, 0.003, 0.002),
        Vector3d(0.08, 0.05, 1e-5), Vector3d(0.1, 1e-5, 1e-5), Vector3d(0.08, 0.05, 0),
        Vector3d(0.1, 0, 0), Vector3d(0, 0, 0)}) {
    for (int n = 0; n < 40; ++n) pieces.push_back(random_piece(random, sides));
  }
  // A triangle and a segment, without repetition.
  pieces.push_back({{{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}}, {{0, 1, 2}}});
  pieces.push_back({{{0, 0, 0}, {0.1, 0, 0}}, {}});
  return pieces;
}

Vector3d random_point_of(const geometry::TriangleMesh& piece, std::mt19937_64& random) {
  std::exponential_distribution<double> exponential;
  Vector3d sum = Vector3d::Zero();
  double weights = 0;
  for (const Vector3d& p : piece.vertices) {
    const double weight = exponential(random);
    sum += weight * p;
    weights += weight;
  }
  return sum / weights;
}

// The vertex that is farthest in some direction is on the surface.
Vector3d random_corner_of(const geometry::TriangleMesh& piece, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const Vector3d way(normal(random), normal(random), normal(random));
  return *std::max_element(
      piece.vertices.begin(), piece.vertices.end(),
      [&way](const Vector3d& a, const Vector3d& b) { return a.dot(way) < b.dot(way); });
}

// Thin ones have no inside: the cover holds all of them.
bool is_thin(const geometry::TriangleMesh& piece) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : piece.vertices) mean += p / static_cast<double>(piece.vertices.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : piece.vertices) spread += (p - mean) * (p - mean).transpose();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvalues()[0] < 1e-6;
}

TEST(DegeneratePieces, AreCoveredByBallsThatEveryWorldTakes) {
  std::mt19937_64 random(8);
  for (const geometry::TriangleMesh& piece : degenerate_pieces()) {
    for (const double resolution : {0.006, 0.015, 0.04}) {
      const BallCover cover = cover_convex_pieces({piece}, resolution);
      ASSERT_FALSE(cover.balls.empty());
      CollisionWorld world;
      for (const Ball& ball : cover.balls) {
        ASSERT_GT(ball.radius, 0);
        ASSERT_NO_THROW(world.add_sphere("held", ball.center, ball.radius));
      }
      for (int n = 0; n < 20; ++n) {
        ASSERT_LE(world.clearance(random_corner_of(piece, random), 0), 1e-6);
      }
      if (!is_thin(piece)) continue;
      for (int n = 0; n < 20; ++n) {
        ASSERT_LE(world.clearance(random_point_of(piece, random), 0), 1e-6);
      }
    }
  }
}

TEST(DegeneratePieces, AreObstaclesAndNeverFartherThanTheyAre) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  for (const geometry::TriangleMesh& piece : degenerate_pieces()) {
    CollisionWorld world;
    ASSERT_NO_THROW(world.add_convex("piece", piece));
    for (int n = 0; n < 20; ++n) {
      const Vector3d p = random_point_of(piece, random);
      EXPECT_LE(world.clearance(p, 0), 1e-6);
      const Vector3d way(normal(random), normal(random), normal(random));
      EXPECT_LE(world.clearance(p + 0.1 * way.normalized(), 0), 0.1 + 1e-6);
    }
    // It is not everywhere either: at most half of the thickness that it got, and a corner's share.
    EXPECT_GT(world.clearance(Vector3d(2, 2, 2), 0), 0.1);
  }
}

TEST(DegeneratePieces, WhatHasNoFiniteVerticesIsRefusedByName) {
  CollisionWorld world;
  const auto refusal = [&](const geometry::TriangleMesh& piece) -> std::string {
    try {
      world.add_convex("spout", piece);
      return "taken";
    } catch (const geometry::InputError& error) {
      return error.what();
    }
  };
  EXPECT_THAT(refusal({}), HasSubstr("'spout' has no vertices"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal({{{0, 0, 0}, {0, nan, 0}}, {}}), HasSubstr("'spout'"));
}

}  // namespace
}  // namespace prehend::motion
