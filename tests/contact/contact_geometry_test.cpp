// Rays against primitives and meshes, and the gate that leaves them out.

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "pads.h"
#include "prehend/contact/mesh_rays.h"
#include "prehend/contact/pad_depths.h"
#include "prehend/contact/rotation.h"
#include "prehend/geometry/errors.h"

namespace prehend::contact {
namespace {

using geometry::RigidTransform;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Vector3d random_vector(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> value(-size, size);
  return {value(random), value(random), value(random)};
}

RigidTransform random_pose(std::mt19937& random, double distance) {
  RigidTransform X = RigidTransform::Identity();
  X.linear() = rotation_by(random_vector(random, 3)).toRotationMatrix();
  X.translation() = random_vector(random, distance);
  return X;
}

// Signed distance of the primitives, for the oracle by sphere tracing.
double signed_distance(const Shape& shape, const Eigen::Vector3d& p) {
  const double radial = p.head<2>().norm();
  switch (shape.kind()) {
    case Shape::Kind::kBox: {
      const Eigen::Vector3d q = p.cwiseAbs() - shape.half_size();
      return q.cwiseMax(0).norm() + std::min(0.0, q.maxCoeff());
    }
    case Shape::Kind::kSphere:
      return p.norm() - shape.radius();
    case Shape::Kind::kCylinder: {
      const Eigen::Vector2d q(radial - shape.radius(), std::abs(p.z()) - shape.half_length());
      return q.cwiseMax(0).norm() + std::min(0.0, q.maxCoeff());
    }
    case Shape::Kind::kCapsule: {
      const double z = std::clamp(p.z(), -shape.half_length(), shape.half_length());
      return (p - Eigen::Vector3d(0, 0, z)).norm() - shape.radius();
    }
    default:
      return p.z();
  }
}

double traced(const Shape& shape, const Eigen::Vector3d& o, const Eigen::Vector3d& d,
              double limit) {
  double t = 0;
  for (int i = 0; i < 100000 && t <= limit; ++i) {
    const double distance = signed_distance(shape, o + t * d);
    if (distance <= 1e-13) return t;
    t += distance;
  }
  return kInfinity;
}

std::vector<Shape> primitives() {
  return {Shape::box({0.05, 0.03, 0.08}), Shape::sphere(0.03), Shape::cylinder(0.02, 0.06),
          Shape::capsule(0.015, 0.05), Shape::half_space()};
}

TEST(Shape, RaysMeetPrimitivesWhereSphereTracingDoes) {
  std::mt19937 random(1);
  for (const Shape& shape : primitives()) {
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d o = random_vector(random, 0.08);
      const Eigen::Vector3d d = random_vector(random, 1).normalized();
      const double expected = traced(shape, o, d, 0.2);
      const double found = shape.ray_distance(o, d, 0.2);
      if (expected == kInfinity || found == kInfinity) {
        // Only rays that graze may differ.
        if (expected != found) {
          const double t = std::min(expected, found);
          EXPECT_LT(std::abs(signed_distance(shape, o + t * d)), 1e-9);
        }
        continue;
      }
      ++hits;
      EXPECT_NEAR(found, expected, 1e-6) << static_cast<int>(shape.kind());
      EXPECT_LT(signed_distance(shape, o + found * d), 1e-12);
    }
    EXPECT_GT(hits, 80);
  }
}

// The nearest point of the surface is `depth` along the normal from the point, and no surface is
// nearer in any direction.
TEST(Shape, DepthInsideIsTheDistanceToTheNearestSurface) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto any = [&] { return Eigen::Vector3d(unit(random), unit(random), unit(random)); };
  for (const Shape& shape :
       {Shape::box({0.1, 0.06, 0.2}), Shape::sphere(0.05), Shape::cylinder(0.04, 0.1),
        Shape::capsule(0.03, 0.08), Shape::half_space()}) {
    int inside = 0;
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d p = 0.1 * any();
      Eigen::Vector3d normal;
      const double depth = shape.depth_inside(p, normal);
      // ray_distance is 0 where a ray begins inside.
      EXPECT_EQ(depth >= 0, shape.ray_distance(p, Eigen::Vector3d::UnitX(), 1) == 0);
      if (!(depth > 0)) continue;
      ++inside;
      EXPECT_NEAR(normal.norm(), 1, 1e-12);
      Eigen::Vector3d ignored;
      EXPECT_NEAR(shape.depth_inside(p + depth * normal, ignored), 0, 1e-12);
      for (int k = 0; k < 20; ++k) {
        const Eigen::Vector3d q = p + 0.999 * depth * any().normalized();
        EXPECT_GT(shape.depth_inside(q, ignored), 0);
      }
    }
    EXPECT_GT(inside, 20);
  }
  Eigen::Vector3d normal;
  EXPECT_EQ(Shape::sphere(0.1).depth_inside(Eigen::Vector3d::Zero(), normal), 0.1);
  EXPECT_EQ(normal.norm(), 1);
  EXPECT_THROW(Shape::mesh(geometry::make_box({1, 1, 1})).depth_inside({0, 0, 0}, normal),
               std::logic_error);
}

TEST(Shape, RaysAlongFacesAndAxes) {
  const Shape box = Shape::box({2, 2, 2});
  EXPECT_EQ(box.ray_distance({-3, 0.5, 0.5}, {1, 0, 0}, 10), 2);
  EXPECT_EQ(box.ray_distance({-3, 1.5, 0.5}, {1, 0, 0}, 10), kInfinity);
  EXPECT_EQ(box.ray_distance({-3, 0, 0}, {-1, 0, 0}, 10), kInfinity) << "behind";
  EXPECT_EQ(box.ray_distance({0, 0, 0}, {1, 0, 0}, 10), 0) << "inside";
  EXPECT_EQ(box.ray_distance({-3, 0, 0}, {1, 0, 0}, 1.9), kInfinity) << "too far";
  const Shape cylinder = Shape::cylinder(1, 2);
  EXPECT_EQ(cylinder.ray_distance({0.5, 0, 3}, {0, 0, -1}, 10), 2);
  EXPECT_EQ(cylinder.ray_distance({1.5, 0, 3}, {0, 0, -1}, 10), kInfinity);
  EXPECT_THROW(Shape::sphere(0), std::invalid_argument);
  EXPECT_THROW(Shape::box({1, std::nan(""), 1}), std::invalid_argument);
  EXPECT_THROW(Shape::capsule(1, -1), std::invalid_argument);
  EXPECT_THROW(Shape::mesh({}), geometry::InputError);
}

// Every triangle's plane and edges (Moeller and Trumbore 1997): the oracle.
double brute_force(const geometry::TriangleMesh& mesh, const Eigen::Vector3d& o,
                   const Eigen::Vector3d& d, double limit) {
  double first = kInfinity;
  bool from_inside = false;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d e1 = mesh.vertices[t[1]] - mesh.vertices[t[0]];
    const Eigen::Vector3d e2 = mesh.vertices[t[2]] - mesh.vertices[t[0]];
    const Eigen::Vector3d p = d.cross(e2);
    const double determinant = e1.dot(p);
    if (std::abs(determinant) < 1e-300) continue;
    const Eigen::Vector3d s = o - mesh.vertices[t[0]], q = s.cross(e1);
    const double u = s.dot(p) / determinant, v = d.dot(q) / determinant;
    const double distance = e2.dot(q) / determinant;
    if (u < 0 || v < 0 || u + v > 1 || distance < 0 || distance >= first) continue;
    first = distance;
    from_inside = determinant < 0;
  }
  if (from_inside) return 0;
  return first <= limit ? first : kInfinity;
}

TEST(MeshRays, EqualBruteForce) {
  std::mt19937 random(2);
  const geometry::TriangleMesh ball = geometry::make_sphere(0.03, 24);
  const MeshRays rays(ball);
  int hits = 0, disagree = 0;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d o = random_vector(random, 0.05);
    const Eigen::Vector3d d = random_vector(random, 1).normalized();
    const double expected = brute_force(ball, o, d, 0.02), found = rays.first_hit(o, d, 0.02);
    if (expected == kInfinity && found == kInfinity) continue;
    ++hits;
    // At the silhouette and at the limit single precision may decide otherwise.
    if (std::abs(found - expected) > 1e-9) ++disagree;
  }
  EXPECT_GT(hits, 500);
  EXPECT_LE(disagree, hits / 200);
}

TEST(FindDepths, MeshAndPrimitiveAgree) {
  std::mt19937 random(3);
  const Eigen::Vector3d size(0.05, 0.04, 0.06);
  const Shape box = Shape::box(size), mesh = Shape::mesh(geometry::make_box(size));
  for (const PadLayout& pad : {PadLayout::flat({}), testing::fingertip()}) {
    const PadReach reach(pad);
    PadState exact(pad), meshed(pad);
    int touched = 0;
    for (int i = 0; i < 300; ++i) {
      RigidTransform X = random_pose(random, 0.001);
      X.translation() -= 0.03 * Eigen::Vector3d::UnitZ() * (i % 2 ? -1 : 1);
      find_depths(pad, reach, box, X, 1e-3, exact);
      find_depths(pad, reach, mesh, X, 1e-3, meshed);
      int differ = 0;
      for (std::size_t t = 0; t < pad.size(); ++t) {
        touched += exact.depth[t] > 0;
        differ += std::abs(exact.depth[t] - meshed.depth[t]) > 1e-9;
      }
      EXPECT_LE(differ, 2) << "rays through an edge";
    }
    EXPECT_GT(touched, 1000);
  }
}

TEST(FindDepths, FlatBoxIsTheGeneralRayByRay) {
  std::mt19937 random(4);
  const PadLayout pad = PadLayout::flat({});
  const PadReach reach(pad);
  const Shape box = Shape::box({0.03, 0.02, 0.04});
  PadState state(pad);
  for (int i = 0; i < 500; ++i) {
    RigidTransform X = random_pose(random, 0.02);
    if (i % 5 == 0) X.linear().setIdentity();
    find_depths(pad, reach, box, X, 0.002, state);
    for (std::size_t t = 0; t < pad.size(); ++t) {
      const Eigen::Vector3d o = pad.position(t) - pad.thickness() * Eigen::Vector3d::UnitZ();
      const double distance =
          box.ray_distance(X.inverse() * o, X.inverse().linear() * Eigen::Vector3d::UnitZ(), 0.005);
      const double expected = distance < kInfinity ? 0.003 - distance : PadState::kFar;
      if (expected == PadState::kFar || state.depth[t] == PadState::kFar) continue;
      EXPECT_NEAR(state.depth[t], expected, 1e-14);
    }
  }
}

TEST(FindDepths, GatedIsBitwiseTheUngated) {
  std::mt19937 random(5);
  std::vector<Shape> shapes = primitives();
  shapes.push_back(Shape::mesh(geometry::make_sphere(0.02, 12)));
  const std::vector<PadLayout> pads{PadLayout::flat({}), testing::fingertip()};
  int left_out = 0, met = 0;
  constexpr int kPoses = 100000;
  std::vector<PadReach> reaches;
  std::vector<PadState> gated, full;
  for (const PadLayout& pad : pads) {
    reaches.emplace_back(pad);
    gated.emplace_back(pad);
    full.emplace_back(pad);
  }
  for (int i = 0; i < kPoses; ++i) {
    const Shape& shape = shapes[i % shapes.size()];
    const std::size_t p = i / shapes.size() % 2;
    const RigidTransform X = random_pose(random, 0.06);
    const bool with = find_depths(pads[p], reaches[p], shape, X, 1e-3, gated[p]);
    const bool without = find_depths(pads[p], reaches[p], shape, X, 1e-3, full[p], false);
    ASSERT_EQ(with, without);
    ASSERT_EQ(gated[p].depth, full[p].depth);
    met += with;
    left_out += !with;
  }
  EXPECT_GT(met, kPoses / 20);
  EXPECT_GT(left_out, kPoses / 20);
}

// Remembered triangles must not show: a body that creeps, stops and jumps.
TEST(FindDepths, RememberedTrianglesAreBitwiseTheCastOnes) {
  std::mt19937 random(6);
  const Shape ball = Shape::mesh(geometry::make_sphere(0.02, 24));
  const PadLayout pad = PadLayout::flat({});
  const PadReach reach(pad);
  PadState with(pad), without(pad);
  MeshHits hits;
  RigidTransform X = RigidTransform::Identity();
  int touched = 0;
  for (int i = 0; i < 3000; ++i) {
    if (i % 100 == 0) X = random_pose(random, 0.004);
    X.translation() += random_vector(random, i % 3 == 0 ? 1e-8 : i % 3 == 1 ? 1e-10 : 0);
    if (i % 100 == 0) X.translation().z() = 0.018;
    const double look_ahead = i % 7 == 0 ? 1e-3 : 1e-5;
    find_depths(pad, reach, ball, X, look_ahead, with, true, &hits);
    find_depths(pad, reach, ball, X, look_ahead, without);
    ASSERT_EQ(with.depth, without.depth);
    touched += with.depth[40] > 0;
  }
  EXPECT_GT(touched, 1000);
}

}  // namespace
}  // namespace prehend::contact
