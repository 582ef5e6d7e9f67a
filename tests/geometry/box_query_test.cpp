// Boxes against surfaces: as FCL tells of each triangle, and as it tells of whole meshes.

#include "prehend/geometry/box_query.h"

#include <limits>
#include <random>
#include <stdexcept>

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/math/bv/OBB.h>
#include <fcl/narrowphase/collision.h>
#include <gtest/gtest.h>

#include "prehend/geometry/mesh_query.h"

namespace prehend::geometry {
namespace {

using Eigen::Vector3d;

double uniform(std::mt19937_64& random) {
  return 2 * (static_cast<double>(random() >> 11) * 0x1.0p-53) - 1;
}

Vector3d any_point(std::mt19937_64& random) {
  return {uniform(random), uniform(random), uniform(random)};
}

RigidTransform any_pose(std::mt19937_64& random, double spread) {
  const Eigen::Quaterniond turn(uniform(random), uniform(random), uniform(random), uniform(random));
  return make_transform(turn.normalized(), spread * any_point(random));
}

/// FCL's hierarchy of boxes, as an oracle.
class FclMesh {
 public:
  explicit FclMesh(const TriangleMesh& mesh) {
    std::vector<fcl::Triangle> triangles;
    for (const auto& t : mesh.triangles) {
      triangles.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                             static_cast<std::size_t>(t[2]));
    }
    hierarchy_.beginModel(static_cast<int>(triangles.size()),
                          static_cast<int>(mesh.vertices.size()));
    hierarchy_.addSubModel(mesh.vertices, triangles);
    hierarchy_.endModel();
  }
  bool meets(const RigidTransform& X_WB, const Vector3d& half_size) const {
    const fcl::Boxd box(Vector3d(2 * half_size));
    fcl::CollisionResultd result;
    fcl::collide(&hierarchy_, RigidTransform::Identity(), &box, X_WB, fcl::CollisionRequestd(),
                 result);
    return result.isCollision();
  }

 private:
  fcl::BVHModel<fcl::OBBd> hierarchy_;
};

TEST(BoxQuery, TrianglesTouchFacesEdgesAndCorners) {
  const Vector3d half(1, 2, 3);
  const auto meets = [&](const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    return does_triangle_meet_box(a, b, c, half);
  };
  EXPECT_TRUE(meets({1, 0, 0}, {2, 0, 0}, {2, 1, 0}));  // a corner on a face
  EXPECT_FALSE(meets({1.001, 0, 0}, {2, 0, 0}, {2, 1, 0}));
  EXPECT_TRUE(meets({9, 9, 0}, {-9, 9, 0}, {0, -9, 0}));  // cuts through, corners far away
  EXPECT_FALSE(meets({9, 9, 3.1}, {-9, 9, 3.1}, {0, -9, 3.1}));
  EXPECT_TRUE(meets({0, 3, 0}, {2, 0, 0}, {5, 5, 0}));                    // its side cuts an edge
  EXPECT_FALSE(meets({0, 4.1, 0}, {4.1, 0, 0}, {5, 5, 0}));               // passes an edge by
  EXPECT_TRUE(meets({0.1, 0.1, 0.1}, {0.2, 0.1, 0.1}, {0.1, 0.2, 0.1}));  // within
  // Segments and points.
  EXPECT_TRUE(meets({-5, 0, 0}, {5, 0, 0}, {0, 0, 0}));
  EXPECT_FALSE(meets({-5, 2.1, 0}, {5, 2.1, 0}, {0, 2.1, 0}));
  EXPECT_FALSE(meets({0, 4.1, 0}, {4.1, 0, 0}, {0, 4.1, 0}));
  EXPECT_TRUE(meets({1, 2, 3}, {1, 2, 3}, {1, 2, 3}));
  EXPECT_FALSE(meets({1, 2, 3.001}, {1, 2, 3.001}, {1, 2, 3.001}));
}

TEST(BoxQuery, FindsWhatFclFinds) {
  std::mt19937_64 random(2);
  const TriangleMesh thin_plate = make_box({0.2, 0.15, 0.0005});
  int met = 0, all = 0;
  for (const TriangleMesh& mesh :
       {make_sphere(0.05, 30), make_box({0.05, 0.1, 0.2}), thin_plate, make_sphere(0.002, 12)}) {
    const MeshQuery query(mesh);
    const FclMesh oracle(mesh);
    for (int n = 0; n < 1500; ++n) {
      const RigidTransform X_WB = any_pose(random, 0.15);
      // Flat ones and long ones, too.
      const Vector3d half_size =
          0.06 * any_point(random).cwiseAbs().cwiseProduct(any_point(random).cwiseAbs()) +
          Vector3d::Constant(1e-4);
      const bool expected = oracle.meets(X_WB, half_size);
      ASSERT_EQ(does_surface_meet_box(query, X_WB, half_size), expected) << n;
      met += expected;
      ++all;
    }
  }
  EXPECT_GT(met, 300);
  EXPECT_LT(met, all - 300);
}

TEST(BoxQuery, BoxesAndPosesThatAreNone) {
  const MeshQuery ball(make_sphere(1, 12));
  const double none = std::numeric_limits<double>::quiet_NaN();
  const RigidTransform here = RigidTransform::Identity();
  for (const Vector3d& half_size : {Vector3d(none, 1, 1), Vector3d(1, -0.1, 1),
                                    Vector3d(1, 1, std::numeric_limits<double>::infinity())}) {
    EXPECT_THROW(does_surface_meet_box(ball, here, half_size), std::invalid_argument);
  }
  RigidTransform nowhere = here;
  nowhere.translation().x() = none;
  EXPECT_FALSE(does_surface_meet_box(ball, nowhere, {1, 1, 1}));
  EXPECT_FALSE(does_surface_meet_box(ball, here, {0, 0, 0}));
}

TEST(BoxQuery, SizesFromMicrometresToKilometres) {
  for (const double scale : {1e-5, 1e-2, 1.0, 1e3}) {
    SCOPED_TRACE(scale);
    const MeshQuery ball(make_sphere(scale, 30));
    const auto meets = [&](double x, const Vector3d& half_size) {
      return does_surface_meet_box(
          ball, make_transform(Eigen::Quaterniond::Identity(), {scale * x, 0, 0}),
          scale * half_size);
    };
    EXPECT_TRUE(meets(1.5, {0.51, 0.1, 0.1}));
    EXPECT_FALSE(meets(1.5, {0.49, 0.1, 0.1}));
    EXPECT_FALSE(meets(0, {0.5, 0.5, 0.5}));  // within, away from the surface
    EXPECT_TRUE(meets(0, {5, 0.01, 0.01}));
    EXPECT_TRUE(meets(0, {100, 100, 100}));
    EXPECT_TRUE(meets(0.985, {0, 0.2, 0.2}));  // a plate
  }
}

}  // namespace
}  // namespace prehend::geometry
